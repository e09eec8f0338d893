import { expect, test } from "vitest";
import type { Point } from "../../wire/protocol";
import { poseRound, rmsDistance } from "./drive";

const TRIANGLE: readonly Point[] = [
  [0, 0],
  [3, 0],
  [3, 4],
];

test("the pose follows the sides of the polygon, round after round", () => {
  expect(poseRound(TRIANGLE, 1)).toEqual([1, 0, 0]);
  expect(poseRound(TRIANGLE, 5)).toEqual([3, 2, Math.PI / 2]);
  const [x, y, yaw] = poseRound(TRIANGLE, 12 + 7 + 2.5);
  expect([x, y]).toEqual([1.5, 2]);
  expect(yaw).toBeCloseTo(Math.atan2(-4, -3), 12);
});

test("the error is the root of the mean square", () => {
  const truth = [
    [0, 0, 0],
    [1, 1, 0],
  ] as const;
  expect(rmsDistance([[3, 4, 9], truth[1]], truth)).toBeCloseTo(5 / Math.SQRT2, 12);
});
