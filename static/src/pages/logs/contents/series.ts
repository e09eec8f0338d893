/** Numeric fields of one topic over time, downsampled by the server. */

import type { Trajectory } from "../../../wire/protocol";

/** An interval of the log's time, seconds. */
export type Span = readonly [from: number, to: number];

/** The number of scans in the map at a time, which are all scans until then. `every` scans lie between two stamps. */
export function scanAtTime(
  { stamps, every }: Pick<Trajectory, "stamps" | "every">,
  seconds: number,
  count: number,
): number {
  let low = 0;
  let high = stamps.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((stamps[middle] ?? 0) <= seconds) low = middle + 1;
    else high = middle;
  }
  if (low === 0) return 0;
  const before = stamps[low - 1] ?? 0;
  const after = stamps[low];
  const into = after === undefined || after <= before ? 0 : (seconds - before) / (after - before);
  return Math.min(count, (low - 1) * every + 1 + Math.floor(into * every));
}
