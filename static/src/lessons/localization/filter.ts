/**
 * Monte Carlo localization as Probabilistic Robotics prints it: the functions of mapper/localization/textbook.py, and
 * tested with vectors from there. Poses are metres and radians; random numbers are arguments.
 */

import type { Pose } from "../../wire/protocol";

export type Alphas = readonly [number, number, number, number];
/** Turn, distance and turn: rad, m, rad. */
export type Control = readonly [turn1: number, distance: number, turn2: number];

/** An angle in −π … π. */
export const wrapped = (angle: number): number => angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));

/** Turn, distance and turn between two poses of the odometry; below 1 cm the first turn is 0. Table 5.6, lines 2 to 4. */
export function odometryControl(before: Pose, after: Pose): Control {
  const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
  const distance = Math.hypot(dx, dy);
  const turn1 = distance < 0.01 ? 0 : wrapped(Math.atan2(dy, dx) - before[2]);
  return [turn1, distance, wrapped(after[2] - before[2] - turn1)];
}

/** Standard deviations of turn, distance and turn. Table 5.6, lines 5 to 7; driving backwards is no half turn. */
export function odometrySigmas([turn1, distance, turn2]: Control, [a1, a2, a3, a4]: Alphas): Control {
  const [r1, r2] = [turn1, turn2].map((r) => Math.min(Math.abs(r), Math.PI - Math.abs(r))) as [number, number];
  const d = distance * distance;
  return [
    Math.sqrt(a1 * r1 * r1 + a2 * d),
    Math.sqrt(a3 * d + a4 * (r1 * r1 + r2 * r2)),
    Math.sqrt(a1 * r2 * r2 + a2 * d),
  ];
}

/** A pose after a motion, with three draws from the standard normal distribution. Table 5.6, lines 5 to 11. */
export function sampleMotion(control: Control, sigmas: Control, [x, y, yaw]: Pose, normals: Control): Pose {
  const turn1 = control[0] - sigmas[0] * normals[0];
  const distance = control[1] - sigmas[1] * normals[1];
  const turn2 = control[2] - sigmas[2] * normals[2];
  return [x + distance * Math.cos(yaw + turn1), y + distance * Math.sin(yaw + turn1), wrapped(yaw + turn1 + turn2)];
}

/** Which particles are drawn for `weights`, Σ = 1, with 0 ≤ r < 1/count. Table 4.4. */
export function lowVarianceSampler(weights: Float64Array, r: number, count: number): Int32Array {
  const drawn = new Int32Array(count);
  let c = weights[0] ?? 0;
  let i = 0;
  for (let m = 0; m < count; m++) {
    const u = r + m / count;
    while (u > c && i < weights.length - 1) c += weights[++i] ?? 0;
    drawn[m] = i;
  }
  return drawn;
}

/** Which particles are drawn where each draw is independent: the loop of table 4.3, lines 8 to 11. */
export function independentSampler(weights: Float64Array, random: () => number, count: number): Int32Array {
  const sorted = Float64Array.from({ length: count }, random).sort();
  const drawn = new Int32Array(count);
  let c = weights[0] ?? 0;
  let i = 0;
  sorted.forEach((u, m) => {
    while (u > c && i < weights.length - 1) c += weights[++i] ?? 0;
    drawn[m] = i;
  });
  return drawn;
}

/** N_eff = 1 / Σ w² of weights with Σ = 1. */
export const effectiveNumber = (weights: Float64Array): number => 1 / weights.reduce((sum, w) => sum + w * w, 0);

/** Weights with Σ = 1; all equal where all are 0. */
export function normalized(weights: Float64Array): Float64Array {
  const sum = weights.reduce((a, b) => a + b, 0);
  return weights.map((w) => (sum > 0 ? w / sum : 1 / weights.length));
}

/** w_slow, w_fast and the share of random particles, max(0, 1 − w_fast / w_slow). Table 8.3, line 10 on. */
export function augmentedShare(
  average: number,
  slow: number,
  fast: number,
  alphaSlow: number,
  alphaFast: number,
): readonly [slow: number, fast: number, share: number] {
  const nowSlow = slow + alphaSlow * (average - slow);
  const nowFast = fast + alphaFast * (average - fast);
  return [nowSlow, nowFast, Math.max(0, 1 - nowFast / nowSlow)];
}

/** Parameters of the beam model, with AMCL's names. */
export interface BeamMixture {
  readonly z_hit: number;
  readonly z_short: number;
  readonly z_max: number;
  readonly z_rand: number;
  readonly sigma_hit: number;
  readonly lambda_short: number;
  readonly range_max: number;
}

/** The four weighted parts of p(z | x, m); `max` is a probability at `range_max`, the others are densities. */
export interface BeamParts {
  readonly hit: number;
  readonly short: number;
  readonly max: number;
  readonly rand: number;
}

/** p(z | x, m) of one reading, where the map has something at `expected`. Table 6.1, equations (6.4) to (6.11). */
export function beamParts(z: number, expected: number, mix: BeamMixture): BeamParts {
  const { sigma_hit: sigma, lambda_short: lambda, range_max } = mix;
  const hit = Math.exp(-0.5 * ((z - expected) / sigma) ** 2) / (sigma * Math.sqrt(2 * Math.PI));
  const share = 1 - Math.exp(-lambda * expected);
  const short = z <= expected && share > 0 ? (lambda * Math.exp(-lambda * z)) / share : 0;
  return {
    hit: mix.z_hit * hit,
    short: mix.z_short * short,
    max: z >= range_max ? mix.z_max : 0,
    rand: z < range_max ? mix.z_rand / range_max : 0,
  };
}

export const beamDensity = (z: number, expected: number, mix: BeamMixture): number => {
  const { hit, short, max, rand } = beamParts(z, expected, mix);
  return hit + short + max + rand;
};

/** Parameters of the likelihood field. */
export interface FieldMixture {
  readonly z_hit: number;
  readonly z_rand: number;
  readonly sigma_hit: number;
  readonly range_max: number;
}

/** The factor of one end point that lies `distance` from the nearest occupied cell. Table 6.3, without 1 / (σ √2π). */
export const fieldDensity = (distance: number, { z_hit, z_rand, sigma_hit, range_max }: FieldMixture): number =>
  z_hit * Math.exp(-(distance * distance) / (2 * sigma_hit * sigma_hit)) + z_rand / range_max;
