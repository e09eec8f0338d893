/**
 * The sensor models of localization: how likely a reading is where the map has something. Probabilistic Robotics, 6.3
 * and 6.4, as mapper/localization/textbook.py, and tested with vectors from there.
 */

/** Parameters of the likelihood field, with AMCL's names; the shares need not sum to 1. */
export interface FieldMixture {
  readonly z_hit: number;
  readonly z_rand: number;
  /** m */
  readonly sigma_hit: number;
  /** m */
  readonly range_max: number;
}

/** Parameters of the beam model. */
export interface BeamMixture extends FieldMixture {
  readonly z_short: number;
  readonly z_max: number;
  /** 1/m */
  readonly lambda_short: number;
}

/** The four weighted parts of p(z | x, m); `max` is a probability at `range_max`, the others are densities, 1/m. */
interface BeamParts {
  readonly hit: number;
  readonly short: number;
  readonly max: number;
  readonly rand: number;
}

const ROOT = Math.sqrt(2 * Math.PI);

/** Height, 1/m, of a normal distribution with a standard deviation in m. */
export const normalPeak = (sigma: number): number => 1 / (sigma * ROOT);

/** The part of a reading `z` of what stands before what the map has `expected` m away, 1/m. */
export function shortDensity(z: number, expected: number, { z_short, lambda_short }: BeamMixture): number {
  const share = 1 - Math.exp(-lambda_short * expected);
  return z <= expected && share > 0 ? (z_short * lambda_short * Math.exp(-lambda_short * z)) / share : 0;
}

/** p(z | x, m) of one reading, where the map has something at `expected`. Table 6.1, equations (6.4) to (6.11). */
export function beamParts(z: number, expected: number, mixture: BeamMixture): BeamParts {
  const { z_hit, z_max, z_rand, sigma_hit, range_max } = mixture;
  return {
    hit: z_hit * normalPeak(sigma_hit) * Math.exp(-0.5 * ((z - expected) / sigma_hit) ** 2),
    short: shortDensity(z, expected, mixture),
    max: z >= range_max ? z_max : 0,
    rand: z < range_max ? z_rand / range_max : 0,
  };
}

export function beamDensity(z: number, expected: number, mixture: BeamMixture): number {
  const { hit, short, max, rand } = beamParts(z, expected, mixture);
  return hit + short + max + rand;
}

/**
 * The factor of a reading that ends `distance` m from the nearest occupied cell; from `reach` m on it is the same. Table
 * 6.3, without 1 / (σ √2π), as in AMCL.
 */
export function fieldLikelihood(
  distance: number,
  { z_hit, z_rand, sigma_hit, range_max }: FieldMixture,
  reach = Number.POSITIVE_INFINITY,
): number {
  const d = Math.min(distance, reach);
  return z_hit * Math.exp(-(d * d) / (2 * sigma_hit * sigma_hit)) + z_rand / range_max;
}
