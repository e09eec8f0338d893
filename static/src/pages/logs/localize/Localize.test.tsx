// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Store } from "../../../store/store";
import { Localize } from "./Localize";
import { Localizing } from "./localizing";

beforeEach(() => vi.stubGlobal("fetch", () => new Promise<Response>(() => undefined)));

afterEach(() => {
  render(null, document.body);
  vi.unstubAllGlobals();
});

test("the notes on a map that was chosen stand beside its size", () => {
  const store = new Store(() => true);
  const localizing = new Localizing(store, "session");
  const note = "Grey 205, which map_saver writes for unknown, counts as free here.";
  const size = { title: "hall.yaml", rows: 200, cols: 300, resolution: 0.05, origin: [0, 0, 0] as const };
  localizing.map.value = { ...size, notes: [note], classes: null };
  act(() => render(<Localize store={store} localizing={localizing} isGuest={false} />, document.body));
  const panel = document.body.textContent;
  expect(panel).toContain("hall.yaml");
  expect(panel).toContain("15.0 × 10.0 m, cells of 5 cm");
  expect([...document.querySelectorAll(".map-note")].map((one) => one.textContent)).toEqual([note]);
});
