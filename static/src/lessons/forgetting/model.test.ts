import { describe, expect, it } from "vitest";
import { logOdds } from "../../grid/cellValues";
import { simulateRemoval } from "./model";

const CLAMP = { on: true, low: -2, high: 3.5 };
const FREE = logOdds(0.25);

describe("forgetting the table", () => {
  it("takes as many scans as the misses need from the clamp to the threshold", () => {
    const { path, forgottenAfter } = simulateRemoval(40, 60, CLAMP);
    expect(path[40]).toBe(3.5);
    expect(path[41]).toBeCloseTo(3.1, 5);
    expect(forgottenAfter).toBe(Math.floor((3.5 - FREE) / 0.4) + 1);
  });

  it("does not depend on how long the table stood, when there is a clamp", () => {
    expect(simulateRemoval(10, 60, CLAMP).forgottenAfter).toBe(simulateRemoval(80, 60, CLAMP).forgottenAfter);
  });

  it("takes as long as the sum of its hits needs, without one", () => {
    const free = { ...CLAMP, on: false };
    for (const seen of [10, 30, 40])
      expect(simulateRemoval(seen, 120, free).forgottenAfter).toBe(Math.floor((0.85 * seen - FREE) / 0.4) + 1);
    expect(simulateRemoval(40, 20, free).forgottenAfter).toBeNull();
  });
});
