import { describe, expect, it } from "vitest";
import { belief, centre, DOORS, type Draw, drawnOf, type Filter, next, occupiedBins, start, weights } from "./corridor";

const steps = (count: number, draw: Draw, particles: number): Filter => {
  let now = start(particles);
  for (let i = 0; i < count; i++) now = next(now, draw, 0.5);
  return now;
};

const meanOf = (values: readonly number[], by: Float64Array): number =>
  values.reduce((sum, value, i) => sum + value * (by[i] ?? 0), 0);

describe("the corridor with doors", () => {
  it("counts the bins with a particle: fewer after a draw", () => {
    expect(occupiedBins(start(24))).toBe(24);
    expect(occupiedBins(start(6))).toBe(6);
    expect(occupiedBins(next(start(24), "low_variance", 0.5))).toBeLessThan(12);
    expect(occupiedBins({ ...start(6), particles: Float64Array.of(0.1, 0.4, 0.6, -1, 12) })).toBe(2);
  });

  it("believes in the three doors alike after the first reading", () => {
    const found = belief(start(24));
    expect(found.reduce((a, b) => a + b, 0)).toBeCloseTo(1, 9);
    const at = DOORS.map((door) => found[Math.floor(door / 0.05)] ?? 0);
    for (const p of at) expect(p / (at[0] ?? 1)).toBeCloseTo(1, 6);
    expect(at[0]).toBeGreaterThan(10 * (found[Math.floor(7 / 0.05)] ?? 1));
  });

  it("knows where it is after the second door, by particles as by the histogram", () => {
    const now = steps(9, "low_variance", 4000); // three rounds of draw, drive and weigh: 3 m, from the first door to the second
    expect(now.phase).toBe("weighed");
    expect(now.robot).toBe(5);
    const exact = belief(now);
    const cells = Array.from(exact, (_, i) => centre(i));
    expect(Math.abs(centre(exact.indexOf(Math.max(...exact))) - 5)).toBeLessThan(0.2);
    expect(exact.filter((_, i) => Math.abs(centre(i) - 5) < 0.8).reduce((a, b) => a + b, 0)).toBeGreaterThan(0.6);
    expect(Math.abs(meanOf([...now.particles], weights(now)) - meanOf(cells, exact))).toBeLessThan(0.15);
  });

  it("takes equally weighed particles once each with the comb, and loses some by independent draws", () => {
    const equal: Filter = { ...start(50), phase: "drawn" };
    const kinds = (draw: Draw): number => new Set(drawnOf(equal, draw, 0.5)).size;
    expect(kinds("low_variance")).toBe(50);
    expect(kinds("independent")).toBeLessThan(42); // 63 % are expected
  });
});
