/**
 * The same evidence in single precision (IEEE 754 binary32, as the mapper stores its cells) in three forms: as a
 * probability, as odds, and as log-odds. Every step is rounded to 24 bits by Math.fround. Nothing is clamped.
 */

import { logOdds } from "../../grid/cellValues";

const f32 = Math.fround;

/** A cell's belief after some readings. */
export interface Belief {
  readonly p: number;
  readonly odds: number;
  readonly logOdds: number;
}

export interface Readings {
  readonly hits: number;
  readonly misses: number;
  /** Probability that a reading alone gives an occupied cell: after a hit, and after a miss. */
  readonly pHit: number;
  readonly pMiss: number;
}

/** One Bayes step in probabilities, each operation rounded: p ← p·q / (p·q + (1 − p)·(1 − q)). */
export function bayesStep(p: number, q: number): number {
  const occupied = f32(p * q);
  const free = f32(f32(1 - p) * f32(1 - q));
  return f32(occupied / f32(occupied + free));
}

/** The belief before the first reading and after each: first the hits, then the misses. */
export function run({ hits, misses, pHit, pMiss }: Readings): readonly Belief[] {
  const [qHit, qMiss] = [f32(pHit), f32(pMiss)];
  const steps = [...Array.from({ length: hits }, () => qHit), ...Array.from({ length: misses }, () => qMiss)];
  let now: Belief = { p: 0.5, odds: 1, logOdds: 0 };
  const beliefs = [now];
  for (const q of steps) {
    now = {
      p: bayesStep(now.p, q),
      odds: f32(now.odds * f32(q / f32(1 - q))),
      logOdds: f32(now.logOdds + f32(logOdds(q))),
    };
    beliefs.push(now);
  }
  return beliefs;
}

/** After which reading a form saturates (p exactly 1 or 0, odds infinite or 0); null if it does not. */
export function saturatedAt(path: readonly Belief[], form: "p" | "odds"): number | null {
  const at = path.findIndex((belief) =>
    form === "p" ? belief.p === 1 || belief.p === 0 : !(belief.odds > 0 && belief.odds < Infinity),
  );
  return at < 0 ? null : at;
}

/** A belief in log-odds, so that the three can be drawn on one axis; ±Infinity where a form has saturated. */
export const asLogOdds = (belief: Belief, form: "p" | "odds" | "logOdds"): number =>
  form === "logOdds"
    ? belief.logOdds
    : form === "odds"
      ? Math.log(belief.odds)
      : Math.log(belief.p) - Math.log(1 - belief.p);
