import { describe, expect, it } from "vitest";
import type { Pose } from "../wire/protocol";
import vectors from "./filter.vectors.json";
import {
  type Alphas,
  type Normals,
  type OmniAlphas,
  odometryControl,
  odometrySigmas,
  sampleMotion,
  sampleOmni,
} from "./motionModel";
import {
  augmentedShare,
  effectiveNumber,
  independentSampler,
  kldNumber,
  kldQuantile,
  lowVarianceSampler,
} from "./particleFilter";
import { seeded } from "./random";
import { type BeamMixture, beamDensity, beamParts, fieldLikelihood } from "./rangeModels";

const near = (found: readonly number[], wanted: readonly number[]): void => {
  expect(found).toHaveLength(wanted.length);
  found.forEach((value, i) => {
    expect(value).toBeCloseTo(wanted[i] ?? Number.NaN, 9);
  });
};

describe("the motion model", () => {
  it("moves as table 5.6", () => {
    for (const { before, after, normals, control, sigmas, pose } of vectors.motions) {
      const from = before as unknown as Pose;
      const found = odometryControl(from, after as unknown as Pose);
      near(found, control);
      const spread = odometrySigmas(found, vectors.alphas as unknown as Alphas);
      near(spread, sigmas);
      near(sampleMotion(found, spread, from, normals as unknown as Normals), pose);
    }
  });

  it("moves sideways as AMCL's omnidirectional model", () => {
    for (const { end, normals, pose } of vectors.omni) {
      const alphas = vectors.alphas as unknown as OmniAlphas;
      near(sampleOmni(end as unknown as Pose, alphas, normals as unknown as Normals), pose);
    }
  });
});

describe("drawing particles", () => {
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

  it("wants as many particles for k bins as table 8.4, and finds the quantile from them", () => {
    for (const { k, error, quantile, n } of vectors.numbers) {
      expect(kldNumber(k, error, quantile)).toBeCloseTo(n, 9);
      if (k > 1) expect(kldQuantile(k, error, n)).toBeCloseTo(quantile, 6);
    }
    // 0.99 taken for the quantile of 99 %, as AMCL takes its parameter, and that quantile itself
    expect(Math.ceil(kldNumber(24, 0.05, 0.99))).toBe(296);
    expect(Math.ceil(kldNumber(24, 0.05, 2.3263))).toBe(417);
  });

  it("averages as table 8.3", () => {
    let [slow, fast] = [0.5, 0.5];
    for (const [average = 0, ...wanted] of vectors.shares) {
      const found = augmentedShare(average, slow, fast, 0.05, 0.4);
      near(found, wanted);
      [slow, fast] = found;
    }
  });
});

describe("the sensor models", () => {
  const mixtures: readonly BeamMixture[] = vectors.mixtures;

  it("have the densities of tables 6.1 and 6.3", () => {
    for (const { z, expected, mix, p } of vectors.densities)
      expect(beamDensity(z, expected, mixtures[mix] as BeamMixture)).toBeCloseTo(p, 9);
    for (const { distance, mix, q } of vectors.fields)
      expect(fieldLikelihood(distance, mixtures[mix] as BeamMixture)).toBeCloseTo(q, 12);
  });

  it("have a field that is level beyond its reach", () => {
    const [mixture] = mixtures as readonly [BeamMixture];
    expect(fieldLikelihood(9, mixture, 0.3)).toBe(fieldLikelihood(0.3, mixture));
    expect(fieldLikelihood(0.2, mixture, 0.3)).toBe(fieldLikelihood(0.2, mixture));
  });

  it("have parts that are probability densities", () => {
    const [mix] = mixtures as readonly [BeamMixture];
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
