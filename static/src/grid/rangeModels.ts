/** The sensor models of localization: how likely a reading is where the map has something. Probabilistic Robotics, 6.3 and 6.4. */

/** The mixture, by AMCL's names; the shares need not sum to 1. */
export interface RangeMixture {
  readonly z_hit: number;
  readonly z_short: number;
  readonly z_max: number;
  readonly z_rand: number;
  /** m */
  readonly sigma_hit: number;
  /** 1/m */
  readonly lambda_short: number;
}

const ROOT = Math.sqrt(2 * Math.PI);

/** The greatest density of a reading of what the map has, 1/m. */
export const hitPeak = ({ z_hit, sigma_hit }: RangeMixture): number => z_hit / (sigma_hit * ROOT);

/** Density of a reading `z` of what the map has `expected` m away. */
export function hitDensity(z: number, expected: number, mixture: RangeMixture): number {
  return hitPeak(mixture) * Math.exp(-0.5 * ((z - expected) / mixture.sigma_hit) ** 2);
}

/** Density of a reading `z` of what stands before it. */
export function shortDensity(z: number, expected: number, { z_short, lambda_short }: RangeMixture): number {
  const share = 1 - Math.exp(-lambda_short * expected);
  return z <= expected && share > 0 ? (z_short * lambda_short * Math.exp(-lambda_short * z)) / share : 0;
}

/** The beam range finder model, table 6.1: density of a reading below `range_max`, 1/m. */
export function beamDensity(z: number, expected: number, range_max: number, mixture: RangeMixture): number {
  return hitDensity(z, expected, mixture) + shortDensity(z, expected, mixture) + mixture.z_rand / range_max;
}

/** The likelihood field, table 6.3 with AMCL's z_hit: of a reading that ends `distance` m from the nearest wall. */
export function fieldLikelihood(distance: number, reach: number, range_max: number, mixture: RangeMixture): number {
  const d = Math.min(distance, reach);
  return mixture.z_hit * Math.exp(-(d * d) / (2 * mixture.sigma_hit ** 2)) + mixture.z_rand / range_max;
}
