// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";
import { Store } from "../../store/store";
import type { PickedMessage, Pose } from "../../wire/protocol";
import { PickingScene } from "./PickingScene";
import { selectionOf, useSelectedPlace } from "./selection";
import { usePicked } from "./usePicked";

vi.mock("./Scene", () => ({ Scene: ({ children }: { children: unknown }) => children })); // which asks the server

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
  const poses: number[] = [];
  function Page() {
    usePicked(store, { onLoop: (edge) => loops.push(edge), onPose: (scan) => poses.push(scan) });
    return <PickingScene store={store} session="s" />;
  }
  act(() => render(<Page />, document.body));
  const said = (): string => document.querySelector("[role=status]")?.textContent ?? "";
  act(() => store.receive(picked("cell")));
  expect(store.explainedPoint.peek()).toEqual([1.5, -2]);
  expect(said()).toContain("Cell at x 1.50 m, y −2.00 m");
  expect(selectionOf(store).peek()?.place).toEqual([1.5, -2]);
  act(() => store.receive(picked("loop", { edge: 7 })));
  expect(store.explainedPoint.peek()).toBeNull();
  expect(selectionOf(store).peek()).toBeNull();
  expect(loops).toEqual([7]);
  act(() => store.receive(picked("pose", { yaw: Math.PI / 2, index: 10 })));
  expect(loops).toEqual([7]);
  expect(poses).toEqual([9]);
  expect(said()).toContain("Pose of scan 10: x 1.50 m, y −2.00 m, 90.0°");
  // The same place once more is a new click.
  act(() => store.receive(picked("loop", { edge: 7 })));
  expect(loops).toEqual([7, 7]);
});

test("what is selected last is marked in 3D, wherever it was selected", () => {
  const marked: unknown[] = [];
  const store = new Store((command) => command.type === "select" && marked.push(command.place) > 0);
  function View() {
    useSelectedPlace(store);
    return null;
  }
  const pose = (x: number): Pose => [x, 1, 0];
  act(() => render(<View />, document.body));
  act(() => store.explain([3, 4]));
  act(() => {
    store.scanPair.value = { scans: [2, 90], poses: [pose(1), pose(5)], points: { i: [], j: [], aligned: null } };
  });
  expect(selectionOf(store).peek()?.scans).toEqual([2, 90]);
  act(() => store.explain(null)); // which was selected before
  act(() => store.receive(picked("pose", { yaw: 0, index: 10 })));
  act(() => {
    store.scanPair.value = null;
  });
  act(() => render(null, document.body));
  expect(marked).toEqual([null, [3, 4], [3, 1], [1.5, -2], undefined]);
});
