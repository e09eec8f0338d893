import { describe, expect, it } from "vitest";
import { optimise } from "./solver";
import { BY_ODOMETRY, errorOf, ODOMETRY, RIGHT_LOOP, WRONG_LOOP } from "./world";

const error = (edges: Parameters<typeof optimise>[1], kernel: "geman_mcclure" | "none"): number =>
  errorOf(optimise(BY_ODOMETRY, edges, { kernel, scale: 3, fixed: [0] }).poses);

describe("the drive round the block", () => {
  it("drifts, is closed by the right loop, and bent by the wrong one unless a kernel refuses it", () => {
    expect(errorOf(BY_ODOMETRY)).toBeGreaterThan(0.8);
    const closed = error([...ODOMETRY, RIGHT_LOOP], "none");
    expect(closed).toBeLessThan(0.3);
    expect(error([...ODOMETRY, RIGHT_LOOP, WRONG_LOOP], "none")).toBeGreaterThan(1);
    expect(error([...ODOMETRY, RIGHT_LOOP, WRONG_LOOP], "geman_mcclure")).toBeCloseTo(closed, 1);
  });
});
