// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Store } from "../../../store/store";
import type { LocalizationResult, LocalizationStatus } from "../../../wire/http";
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
  expect([...document.querySelectorAll(".map-note")].map((element) => element.textContent)).toEqual([note]);
});

test.each([
  [12, "12 scans, whose poses are not known: no map along these poses has them"],
  [0, null],
])("of %i scans whose poses are not known there is a line", (leftOut, said) => {
  const store = new Store(() => true);
  const localizing = new Localizing(store, "session");
  const result: LocalizationResult = {
    map_title: "hall",
    odometry: "/odom",
    first_converged: leftOut,
    converged: 80,
    is_converged: true,
    updates: 92,
    median_fit: 0.9,
    cpu_s: 1.5,
    sure: 80,
    is_sure: true,
    left_out: leftOut,
    trajectory: "localized",
  };
  localizing.job.value = {
    state: "done",
    created_s: 0,
    error: null,
    fraction: 1,
    elapsed_s: 2,
    ahead: 0,
    log: "log",
    topic: null,
    odometry: null,
    parameters: {} as LocalizationStatus["parameters"],
    result,
    scans: 92,
    is_converged: true,
    n_particles: 500,
  };
  act(() => render(<Localize store={store} localizing={localizing} isGuest={false} />, document.body));
  const terms = [...document.querySelectorAll(".facts-list dt")].map((element) => element.textContent);
  expect(terms).toContain("Converged");
  const place = terms.indexOf("Left out");
  const values = [...document.querySelectorAll(".facts-list dd")].map((element) => element.textContent);
  expect(values[place] ?? null).toBe(said);
});
