import { describe, expect, it } from "vitest";
import { likelihood, motionModel, POSITIONS, placeOf, posterior, squaredDistances } from "./model";

const best = (name: Parameters<typeof placeOf>[0], says: number, sigma = 0.5): number =>
  posterior(likelihood(squaredDistances(placeOf(name)), 0.1), motionModel(says, sigma)).best;

describe("the most probable position", () => {
  it("is where the scan fits, however wrong the odometry, where only one place fits", () => {
    const { truth } = placeOf("cabinets");
    expect(best("cabinets", truth + 1)).toBeCloseTo(truth, 1);
    expect(best("cabinets", truth - 1)).toBeCloseTo(truth, 1);
  });

  it("is the alike place that the odometry is nearest to, between doors", () => {
    const { truth } = placeOf("doors");
    expect(best("doors", truth + 0.4)).toBeCloseTo(truth, 1);
    expect(best("doors", truth + 1.7)).toBeCloseTo(truth + 2, 1);
  });

  it("is what the odometry says in a bare corridor", () => {
    for (const says of [3, 4.7, 7]) expect(best("bare", says)).toBeCloseTo(says, 1);
  });

  it("weighs two normal distributions by their information", () => {
    const { best: at } = posterior(motionModel(4, 0.5), motionModel(6, 1));
    expect(at).toBeCloseTo((4 / 0.25 + 6 / 1) / (1 / 0.25 + 1), 1);
    expect(POSITIONS).toContain(at);
  });
});
