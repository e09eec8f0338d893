// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";
import { Store } from "../../store/store";
import type { PickedMessage } from "../../wire/protocol";
import { PickingScene } from "./PickingScene";
import { usePicked } from "./usePicked";

vi.mock("./Scene", () => ({ Scene: () => null })); // which asks the server

afterEach(() => render(null, document.body));

const picked = (what: PickedMessage["what"], more: Partial<PickedMessage> = {}): PickedMessage => ({
  type: "picked",
  what,
  x: 1.5,
  y: -2,
  yaw: null,
  index: null,
  edge: null,
  ...more,
});

test("what is clicked in 3D is selected on the map, and said beside the view", () => {
  const store = new Store(() => true);
  const loops: number[] = [];
  function Page() {
    usePicked(store, (edge) => loops.push(edge));
    return <PickingScene store={store} session="s" />;
  }
  act(() => render(<Page />, document.body));
  const said = (): string => document.querySelector("[role=status]")?.textContent ?? "";
  act(() => store.receive(picked("cell")));
  expect(store.explainedPoint.peek()).toEqual([1.5, -2]);
  expect(said()).toContain("Cell at x 1.50 m, y −2.00 m");
  act(() => store.receive(picked("loop", { edge: 7 })));
  expect(store.explainedPoint.peek()).toBeNull();
  expect(loops).toEqual([7]);
  act(() => store.receive(picked("pose", { yaw: Math.PI / 2, index: 10 })));
  expect(loops).toEqual([7]);
  expect(said()).toContain("Pose of scan 10: x 1.50 m, y −2.00 m, 90.0°");
  // The same place once more is a new click.
  act(() => store.receive(picked("loop", { edge: 7 })));
  expect(loops).toEqual([7, 7]);
});
