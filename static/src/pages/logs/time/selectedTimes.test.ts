import { expect, test } from "vitest";
import { Store } from "../../../store/store";
import type { PickedMessage, Trajectory, WhyMessage } from "../../../wire/protocol";
import { selectedTimes } from "./scanTimes";

test("what is selected has the times of its scans, a cell that of the selected beam", () => {
  const store = new Store(() => true);
  expect(selectedTimes(store)).toEqual([]);
  store.receive({ type: "trajectory", stamps: [0, 1, 2, 3], every: 10 } as unknown as Trajectory);
  const at = { x: 1, y: 2, yaw: 0, edge: null };
  store.receive({ type: "picked", what: "pose", index: 16, ...at } satisfies PickedMessage);
  expect(selectedTimes(store)).toEqual([1.5]);
  store.scanPair.value = {
    scans: [5, 30],
    poses: [
      [0, 0, 0],
      [1, 0, 0],
    ],
    points: { i: [], j: [], aligned: null },
  };
  expect(selectedTimes(store)).toEqual([0.5, 3]);
  store.explain([1, 2]);
  expect(selectedTimes(store)).toEqual([]);
  store.why.value = { contributions: [{ n: 1, stamp: 2.5 }], total: 1 } as unknown as WhyMessage;
  expect(selectedTimes(store)).toEqual([2.5]);
});
