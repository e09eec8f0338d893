import { expect, test } from "vitest";
import vectors from "./filter.vectors.json";
import { type Alphas, type Normals, type Pose3, sampleDifferential, sampleOmni } from "./motionModel";
import { beamDensity, fieldLikelihood, type RangeMixture } from "./rangeModels";

const mixtureOf = (row: readonly number[]): RangeMixture => {
  const [z_hit = 0, z_short = 0, z_max = 0, z_rand = 0, sigma_hit = 0, lambda_short = 0] = row;
  return { z_hit, z_short, z_max, z_rand, sigma_hit, lambda_short };
};

test("the beam model is the library's", () => {
  for (const { z, expected, range_max, mixture, p } of vectors.beams)
    expect(beamDensity(z, expected, range_max, mixtureOf(mixture))).toBeCloseTo(p, 9);
});

test("the likelihood field is the library's, and level beyond its reach", () => {
  for (const { distance, range_max, mixture, p } of vectors.fields)
    expect(fieldLikelihood(distance, 2, range_max, mixtureOf(mixture))).toBeCloseTo(p, 9);
  const mixture = mixtureOf([0.5, 0, 0, 0.5, 0.2, 1]);
  expect(fieldLikelihood(9, 0.3, 8, mixture)).toBe(fieldLikelihood(0.3, 0.3, 8, mixture));
});

test("samples of a motion are the library's", () => {
  const models = { differential: sampleDifferential, omni: sampleOmni };
  for (const row of vectors.motions) {
    for (const name of ["differential", "omni"] as const) {
      const [end, alphas, normals] = [row.end, row.alphas, row.normals] as unknown as [Pose3, Alphas, Normals];
      const [x, y, yaw] = models[name](end, alphas, normals);
      [x, y, Math.cos(yaw), Math.sin(yaw)].forEach((value, i) => {
        expect(value).toBeCloseTo(row[name][i] as number, 9);
      });
    }
  }
});
