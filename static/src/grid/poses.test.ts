import { expect, test } from "vitest";
import type { Pose } from "../wire/protocol";
import { between } from "./poses";

test("a mount is the same wherever the robot is", () => {
  for (const yaw of [0, 1, -2.5, Math.PI]) {
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
    const base: Pose = [3, -4, yaw];
    const laser: Pose = [3 + 0.2 * cos - 0.1 * sin, -4 + 0.2 * sin + 0.1 * cos, yaw + 0.5];
    between(base, laser).forEach((value, n) => {
      expect(value).toBeCloseTo([0.2, 0.1, 0.5][n] ?? 0, 12);
    });
  }
  expect(between([0, 0, 3], [0, 0, -3])[2]).toBeCloseTo(2 * Math.PI - 6, 12);
});
