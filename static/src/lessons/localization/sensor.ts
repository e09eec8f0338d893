/**
 * The beam model forwards, p(z | x, m), and what it says about the cells of a beam when it is inverted by Bayes' rule.
 *
 * Source: Probabilistic Robotics, table 6.1 for the model; chapter 9 for inverse models that are derived from forward
 * ones. Metres along one beam.
 */

import { type BeamMixture, beamDensity } from "../../grid/rangeModels";

export const RANGE_MAX = 8;
export const FIRST: BeamMixture = {
  z_hit: 0.7,
  z_short: 0.15,
  z_max: 0.09,
  z_rand: 0.06,
  sigma_hit: 0.3,
  lambda_short: 0.5,
  range_max: RANGE_MAX,
};

export type Share = "z_hit" | "z_short" | "z_max" | "z_rand";
const SHARES: readonly Share[] = ["z_hit", "z_short", "z_max", "z_rand"];

/** The mixture with another share; the three others change in proportion, so that the sum stays 1. */
export function withShare(mix: BeamMixture, name: Share, value: number): BeamMixture {
  const share = Math.min(0.97, Math.max(0, value));
  const others = SHARES.filter((share) => share !== name);
  const rest = others.reduce((sum, share) => sum + mix[share], 0);
  const scaled = others.map(
    (other) => [other, rest > 0 ? (mix[other] * (1 - share)) / rest : (1 - share) / 3] as const,
  );
  return { ...mix, ...Object.fromEntries(scaled), [name]: share };
}

/** Side of a cell of the beam. */
export const CELL = 0.25;
const CELLS = Math.round(RANGE_MAX / CELL);

/**
 * p(mᵢ | z, x) of each cell along a beam by Bayes' rule, where each cell is occupied with probability `prior`.
 *
 * The reading depends on the first occupied cell only, so the sum over all 2ⁿ maps is one over n + 1 cases. `cells` is
 * n; cells of {@link CELL} metres unless `side` says otherwise.
 */
export function inverse(z: number, mix: BeamMixture, prior: number, cells: number, side = CELL): Float64Array {
  const joint = new Float64Array(cells + 1);
  let empty = 1; // probability that all cells before are free
  for (let k = 0; k <= cells; k++) {
    const expected = k < cells ? (k + 0.5) * side : mix.range_max;
    joint[k] = empty * (k < cells ? prior : 1) * beamDensity(z, expected, mix);
    empty *= 1 - prior;
  }
  const total = joint.reduce((a, b) => a + b, 0);
  let before = 0; // probability that the first occupied cell is nearer
  return Float64Array.from({ length: cells }, (_, i) => {
    const first = (joint[i] ?? 0) / total;
    const p = first + before * prior;
    before += first;
    return p;
  });
}

const logit = (p: number): number => Math.log(p / (1 - p));
const LIMIT = 0.98;

/** The evidence ℓ − ℓ₀ that {@link inverse} gives for each cell. */
export const evidence = (z: number, mix: BeamMixture, prior: number): Float64Array =>
  inverse(z, mix, prior, CELLS).map((p) => logit(p) - logit(prior));

/**
 * The log-odds that come out where p(z | wall at s), relative to its greatest value over s, is mistaken for the
 * probability of the cell at s.
 */
export function backwards(z: number, mix: BeamMixture): Float64Array {
  const values = Float64Array.from({ length: CELLS }, (_, k) => beamDensity(z, (k + 0.5) * CELL, mix));
  const most = values.reduce((a, b) => Math.max(a, b), 0);
  return values.map((value) => logit(Math.min(LIMIT, Math.max(1 - LIMIT, value / most))));
}
