import { describe, expect, it } from "vitest";
import { seeded } from "../../grid/random";
import {
  type Alphas,
  augmentedShare,
  type BeamMixture,
  beamDensity,
  beamParts,
  type Control,
  effectiveNumber,
  fieldDensity,
  independentSampler,
  lowVarianceSampler,
  odometryControl,
  odometrySigmas,
  sampleMotion,
} from "./filter";
import vectors from "./filter.vectors.json";

const near = (found: readonly number[], wanted: readonly number[]): void => {
  expect(found).toHaveLength(wanted.length);
  found.forEach((value, i) => {
    expect(value).toBeCloseTo(wanted[i] ?? Number.NaN, 9);
  });
};

describe("the particle filter of the lecture", () => {
  it("moves as table 5.6", () => {
    for (const { before, after, control, sigmas, pose } of vectors.motions) {
      const from = before as [number, number, number];
      const found = odometryControl(from, after as [number, number, number]);
      near(found, control);
      const spread = odometrySigmas(found, vectors.alphas as unknown as Alphas);
      near(spread, sigmas);
      near(sampleMotion(found, spread, from, vectors.normals as unknown as Control), pose);
    }
  });

  it("draws as table 4.4", () => {
    for (const { weights, r, count, drawn, effective } of vectors.draws) {
      expect([...lowVarianceSampler(Float64Array.from(weights), r, count)]).toEqual(drawn);
      expect(effectiveNumber(Float64Array.from(weights))).toBeCloseTo(effective, 9);
    }
  });

  it("draws each particle about as often as its weight says, also by independent draws", () => {
    const weights = Float64Array.of(0.1, 0.6, 0.3);
    const drawn = independentSampler(weights, seeded(3), 6000);
    const counts = [0, 1, 2].map((i) => drawn.filter((k) => k === i).length / 6000);
    counts.forEach((share, i) => {
      expect(Math.abs(share - (weights[i] ?? 0))).toBeLessThan(0.02);
    });
  });

  it("averages as table 8.3", () => {
    let [slow, fast] = [0.5, 0.5];
    for (const [average = 0, ...wanted] of vectors.shares) {
      const found = augmentedShare(average, slow, fast, 0.05, 0.4);
      near(found, wanted);
      [slow, fast] = found;
    }
  });

  it("has the densities of tables 6.1 and 6.3", () => {
    for (const { z, expected, mix, p } of vectors.densities) {
      const mixture = vectors.mixtures[mix] as BeamMixture;
      expect(beamDensity(z, expected, mixture)).toBeCloseTo(p, 9);
    }
    for (const { distance, q } of vectors.fields)
      expect(fieldDensity(distance, { z_hit: 0.5, z_rand: 0.5, sigma_hit: 0.2, range_max: 8 })).toBeCloseTo(q, 12);
  });

  it("has parts that are probability densities", () => {
    const mix = vectors.mixtures[0] as BeamMixture;
    const step = 0.001;
    const sums = { hit: 0, short: 0, rand: 0 };
    for (let z = step / 2; z < mix.range_max; z += step) {
      const parts = beamParts(z, 3, mix);
      for (const name of ["hit", "short", "rand"] as const) sums[name] += parts[name] * step;
    }
    expect(sums.hit).toBeCloseTo(mix.z_hit, 3);
    expect(sums.short).toBeCloseTo(mix.z_short, 3);
    expect(sums.rand).toBeCloseTo(mix.z_rand, 3);
  });
});
