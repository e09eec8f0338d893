import { describe, expect, it } from "vitest";
import { beamDensity } from "../../grid/rangeModels";
import { backwards, evidence, FIRST, inverse, type Share, withShare } from "./sensor";

describe("the inverse of the beam model", () => {
  it("is the sum over all maps", () => {
    const [cells, side, prior, z] = [9, 0.8, 0.3, 3.1];
    const sums = new Float64Array(cells);
    let total = 0;
    for (let map = 0; map < 2 ** cells; map++) {
      const has = (i: number): boolean => ((map >> i) & 1) === 1;
      const bits = Array.from({ length: cells }, (_, i) => has(i));
      const first = bits.indexOf(true);
      const p =
        beamDensity(z, first < 0 ? FIRST.range_max : (first + 0.5) * side, FIRST) *
        bits.reduce((product, bit) => product * (bit ? prior : 1 - prior), 1);
      total += p;
      bits.forEach((bit, i) => {
        sums[i] = (sums[i] ?? 0) + (bit ? p : 0);
      });
    }
    inverse(z, FIRST, prior, cells, side).forEach((p, i) => {
      expect(p).toBeCloseTo((sums[i] ?? 0) / total, 12);
    });
  });

  it("says free before the reading, occupied at it, and nothing behind, which p(z | m) read backwards does not", () => {
    const found = evidence(5.1, FIRST, 0.05);
    const read = backwards(5.1, FIRST);
    const [before, at, behind] = [8, 20, 28];
    expect(found[before]).toBeLessThan(-1);
    expect(found[at]).toBeGreaterThan(1.5);
    expect(found.indexOf(Math.max(...found))).toBe(at);
    expect(Math.abs(found[behind] ?? 1)).toBeLessThan(0.35);
    expect(read[before]).toBeLessThan(-2);
    expect(read[behind]).toBeLessThan(-2);
  });
});

describe("the shares of the mixture", () => {
  it("always sum to 1", () => {
    let mix = FIRST;
    const changes: readonly (readonly [Share, number])[] = [
      ["z_hit", 0.9],
      ["z_max", 0],
      ["z_rand", 0.97],
      ["z_short", 2],
    ];
    for (const [name, value] of changes) {
      mix = withShare(mix, name, value);
      expect(mix.z_hit + mix.z_short + mix.z_max + mix.z_rand).toBeCloseTo(1, 12);
      expect(mix[name]).toBeCloseTo(Math.min(0.97, value), 12);
    }
  });
});
