/** The explanation of a cell in words and numbers. */

import { probability } from "../../grid/cellValues";
import { signed, written } from "../../ui/numbers";
import { FREE_THRESHOLD, OCCUPIED_THRESHOLD } from "../../wire/constants";
import type { CellState, Contribution, WhyMessage } from "../../wire/protocol";

export function stateOf(why: WhyMessage): CellState | "never observed" {
  if (why.total === 0) return "never observed";
  const p = probability(why.log_odds);
  return p > OCCUPIED_THRESHOLD ? "occupied" : p < FREE_THRESHOLD ? "free" : "unknown";
}

const beams = (n: number): string => (n === 1 ? "1 beam" : `${n} beams`);

/**
 * The effect of an update in words. With a hit window, a beam that ends near the cell is also evidence for occupied.
 */
export function verdict(
  { hit, range, outweighed }: Pick<Contribution, "hit" | "range" | "outweighed">,
  window: number,
): string {
  if (hit) return window > 0 ? "ended at or near it" : "ended here";
  const passed = range === null ? "passed through without return" : "passed through";
  return outweighed ? `${passed}, but other beams of its scan ended here: it counts for nothing` : passed;
}

/** The number of misses without effect, in words. */
const outweighed = (why: WhyMessage): string =>
  why.outweighed > 0 ? ` (${why.outweighed} of them in scans that hit it, where only the hits count)` : "";

/** The explanation in one sentence. `last` is the newest update, null if the answer does not contain it. */
export function sentence(why: WhyMessage, last: Contribution | null, window: number): string {
  const value = `ℓ ${written(why.log_odds, 2)}`;
  if (why.total === 0) {
    const scans = why.index === 1 ? "the 1 scan" : `the ${why.index} scans`;
    return `Never observed: no beam of ${scans} in the map updated this cell. It has its prior value, ${value}.`;
  }
  const state = stateOf(why);
  const head = `${state.charAt(0).toUpperCase()}${state.slice(1)}, p ${written(probability(why.log_odds), 2)}`;
  const misses = why.total - why.hits;
  const counts = why.per_scan
    ? `each scan counts once, ${why.hits} as a hit, ${misses} as a miss`
    : `${beams(why.hits)} ${verdict({ hit: true, range: 0 }, window)}, ${misses} passed through${outweighed(why)}`;
  if (!last) return `${head}: ${counts}.`;
  const reading = last.range === null ? "" : ` at ${written(last.range, 1)} m`;
  return `${head}: ${counts}; the last, from scan ${last.scan + 1}${reading}, ${verdict(last, window)}.`;
}

/** The numbers of one update. */
export interface Update {
  readonly before: number;
  readonly increment: number;
  /** Before the clamp. */
  readonly sum: number;
  readonly after: number;
  readonly isClamped: boolean;
}

/** The numbers of update `n`; null if the answer does not contain it and the one before. */
export function updateOf(why: WhyMessage, n: number): Update | null {
  const first = why.contributions[0]?.n ?? 1;
  const contribution = why.contributions[n - first];
  const before = n === 1 ? why.prior : why.contributions[n - first - 1]?.log_odds;
  if (!contribution || before === undefined) return null;
  const sum = before + contribution.increment;
  return {
    before,
    increment: contribution.increment,
    sum,
    after: contribution.log_odds,
    isClamped: Math.abs(sum - contribution.log_odds) > 1e-4,
  };
}

/** An update as an equation: −0.40 + 0.85 = 0.45. */
export function equation({ before, increment, sum, after, isClamped }: Update): string {
  const step = `${written(before, 2)} ${increment < 0 ? "−" : "+"} ${written(Math.abs(increment), 2)}`;
  return `${step} = ${written(sum, 2)}${isClamped ? ` → ${written(after, 2)}` : ""}`;
}

/** An update in one line. */
export function describe(contribution: Contribution, window: number): string {
  const reading = contribution.range === null ? "no return" : `${written(contribution.range, 2)} m`;
  return `scan ${contribution.scan + 1}, beam ${contribution.beam + 1}, ${reading}: ${verdict(contribution, window)}, ${signed(contribution.increment)}`;
}

/** The log-odds before the first update and after those in the answer's curve, as [n, log-odds]. */
export const logOddsCurve = (why: WhyMessage): readonly (readonly [n: number, log_odds: number])[] => [
  [0, why.prior],
  ...why.curve,
];
