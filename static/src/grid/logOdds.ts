/** Log-odds and probability. */

/** p = 1 − 1 / (1 + exp ℓ). */
export function probability(logOdds: number): number {
  const small = Math.exp(-Math.abs(logOdds));
  return logOdds >= 0 ? 1 / (1 + small) : small / (1 + small);
}

/** ℓ = log(p / (1 − p)). */
export function logOdds(p: number): number {
  return Math.log(p) - Math.log1p(-p);
}
