import { describe, expect, it } from "vitest";
import { logOdds } from "../../grid/cellValues";
import { asLogOdds, bayesStep, run, saturatedAt } from "./model";

const READINGS = { hits: 60, misses: 60, pHit: 0.7, pMiss: 0.3 };

describe("three representations of a belief in single precision", () => {
  it("agree while there are digits", () => {
    const path = run({ ...READINGS, hits: 6, misses: 3 });
    const exact = 3 * logOdds(0.7);
    const last = path.at(-1);
    if (!last) throw new Error("no path");
    for (const form of ["p", "odds", "logOdds"] as const) expect(asLogOdds(last, form)).toBeCloseTo(exact, 4);
  });

  it("lose the probability once 1 − p is no longer a number of 24 bits", () => {
    const path = run(READINGS);
    const saturated = saturatedAt(path, "p") as number;
    // Below 1 the next number is 1 − 2⁻²⁴; half of that gap away, at ℓ ≈ 25 log 2, a step rounds to 1 itself.
    expect(saturated * logOdds(0.7)).toBeGreaterThan(23 * Math.LN2);
    expect(saturated * logOdds(0.7)).toBeLessThan(26 * Math.LN2);
    expect(path.slice(saturated).every((belief) => belief.p === 1)).toBe(true);
    expect(bayesStep(1, 0.3)).toBe(1);
    expect(path.at(-1)?.logOdds).toBeCloseTo(0, 3);
  });

  it("lose the odds when they pass the greatest number, and then even Bayes' rule cannot bring them back", () => {
    const path = run({ ...READINGS, hits: 120, misses: 200 });
    const saturated = saturatedAt(path, "odds") as number;
    expect(saturated).toBe(Math.ceil((128 * Math.LN2) / logOdds(0.7)));
    expect(path.at(-1)?.odds).toBe(Infinity);
    expect(path.at(-1)?.logOdds).toBeCloseTo(-80 * logOdds(0.7), 2);
  });

  it("never lose the sum", () => {
    const path = run({ ...READINGS, hits: 200, misses: 200 });
    expect(path.every((belief) => Number.isFinite(belief.logOdds))).toBe(true);
    expect(path.at(-1)?.logOdds).toBeCloseTo(0, 3);
  });
});
