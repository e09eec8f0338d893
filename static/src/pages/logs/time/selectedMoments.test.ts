import { expect, test } from "vitest";
import { Store } from "../../../store/store";
import type { PickedMessage, Trajectory, WhyMessage } from "../../../wire/protocol";
import { selectedMoments } from "./scanTimes";

test("what is selected has the moments of its scans, a cell that of the selected beam, at first the last", () => {
  const store = new Store(() => true);
  expect(selectedMoments(store)).toEqual([]);
  store.receive({ type: "trajectory", stamps: [0, 1, 2, 3], every: 10 } as unknown as Trajectory);
  const at = { x: 1, y: 2, yaw: 0, edge: null };
  store.receive({ type: "picked", what: "pose", index: 16, ...at } satisfies PickedMessage);
  expect(selectedMoments(store)).toEqual([{ scan: 15, seconds: 1.5 }]);
  store.scanPair.value = {
    scans: [5, 30],
    poses: [
      [0, 0, 0],
      [1, 0, 0],
    ],
    points: { i: [], j: [], aligned: null },
  };
  expect(selectedMoments(store)).toEqual([
    { scan: 5, seconds: 0.5 },
    { scan: 30, seconds: 3 },
  ]);
  store.explain([1, 2]);
  expect(selectedMoments(store)).toEqual([]);
  const contributions = [
    { n: 1, scan: 3, stamp: 0.3 },
    { n: 2, scan: 25, stamp: 2.5 },
  ];
  store.why.value = { contributions, total: 2 } as unknown as WhyMessage;
  expect(selectedMoments(store)).toEqual([{ scan: 25, seconds: 2.5 }]);
  store.selectedUpdate.value = 1;
  expect(selectedMoments(store)).toEqual([{ scan: 3, seconds: 0.3 }]);
});
