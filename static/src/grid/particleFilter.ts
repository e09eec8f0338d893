/**
 * Resampling of the particles of Monte Carlo localization, as Probabilistic Robotics prints it: the functions of
 * mapper/localization/textbook.py, and tested with vectors from there. Random numbers are arguments.
 */

/** Which particles are drawn for `weights`, Σ = 1, with 0 ≤ first < 1/count. Table 4.4. */
export function lowVarianceSampler(weights: Float64Array, first: number, count: number): Int32Array {
  const drawn = new Int32Array(count);
  let c = weights[0] ?? 0;
  let i = 0;
  for (let m = 0; m < count; m++) {
    const u = first + m / count;
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

/** How many particles k occupied bins need so that the KL distance is below `error` at a quantile of the normal distribution. Table 8.4. */
export function kldNumber(k: number, error: number, quantile: number): number {
  if (k < 2) return 0;
  const a = 2 / (9 * (k - 1));
  return ((k - 1) / (2 * error)) * (1 - a + Math.sqrt(a) * quantile) ** 3;
}

/** The quantile at which k bins need n particles: the inverse of {@link kldNumber}. */
export function kldQuantile(k: number, error: number, n: number): number {
  const a = 2 / (9 * (k - 1));
  return (Math.cbrt((2 * error * n) / (k - 1)) - 1 + a) / Math.sqrt(a);
}
