/** The meaning of a cell's byte: log-odds, probability and state, for the geometry of the same stream. */

import { FREE_THRESHOLD, OCCUPIED_THRESHOLD } from "../wire/constants";
import type { CellState, Geometry } from "../wire/protocol";

/** p = 1 − 1 / (1 + exp ℓ). */
export function probability(logOdds: number): number {
  const small = Math.exp(-Math.abs(logOdds));
  return logOdds >= 0 ? 1 / (1 + small) : small / (1 + small);
}

/** ℓ = log(p / (1 − p)). */
export function logOdds(p: number): number {
  return Math.log(p) - Math.log1p(-p);
}

type Range = Pick<Geometry, "low" | "high">;

/** The log-odds of a byte 1 … 255 (0 is "never observed" and has none). */
export function logOddsAt(byte: number, range: Range): number {
  return range.low + ((byte - 1) / 254) * (range.high - range.low);
}

/** The byte of a log-odds value, not rounded and not limited. */
export function byteAt(logOdds: number, range: Range): number {
  return 1 + (254 * (logOdds - range.low)) / (range.high - range.low);
}

/** The same, limited to 1 … 255: the ends stand for all values beyond them. */
export const shownByteAt = (logOdds: number, range: Range): number =>
  Math.min(255, Math.max(1, byteAt(logOdds, range)));

export function stateAt(byte: number, range: Range): CellState {
  if (byte === 0) return "unknown";
  const value = logOddsAt(byte, range);
  if (value > logOdds(OCCUPIED_THRESHOLD)) return "occupied";
  return value < logOdds(FREE_THRESHOLD) ? "free" : "unknown";
}

/** The bytes below which a cell is free and above which it is occupied. */
export function thresholds(range: Range): { below: number; above: number } {
  return { below: byteAt(logOdds(FREE_THRESHOLD), range), above: byteAt(logOdds(OCCUPIED_THRESHOLD), range) };
}
