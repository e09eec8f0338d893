/** Computations of the plots below a log's timeline. */

import { written } from "../../../ui/numbers";
import type { ScanSeries, SeriesColumn } from "../../../wire/http";
import type { Trajectory } from "../../../wire/protocol";
import { type Span, scanAtTime } from "../contents/series";

/** The number of scans in the map at a position on the axis. */
export function scanAtPlace(axis: ScanSeries["axis"], trajectory: Trajectory, place: number, count: number): number {
  if (axis === "time") return scanAtTime(trajectory, place, count);
  return Math.min(count, Math.max(0, Math.round(place) + 1));
}

/** The position on the axis of the newest of `index` scans. */
export function placeOfScan(axis: ScanSeries["axis"], { stamps, every }: Trajectory, index: number): number {
  const scan = Math.max(0, index - 1);
  if (axis === "scan") return scan;
  const before = stamps[Math.floor(scan / every)] ?? 0;
  const after = stamps[Math.floor(scan / every) + 1] ?? before;
  return before + ((after - before) * (scan % every)) / every;
}

/** Index of the value nearest in time; `times` ascend. −1 without values. */
export function nearest(times: readonly number[], at: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) < at) low = middle + 1;
    else high = middle;
  }
  const after = times[low];
  const before = times[low - 1];
  if (after === undefined) return low - 1;
  return before !== undefined && at - before < after - at ? low - 1 : low;
}

/** The range of a plot's y axis, and the extreme value outside it, null for none. */
export interface Shown {
  readonly low: number;
  readonly high: number;
  readonly beyond: number | null;
}

/** Share of the values that are treated as outliers, at either end. */
const OUTLIERS = 0.01;
/** Margin of the axis beyond all other values, as a fraction of their range. A nearer outlier is inside it. */
const MARGIN = 1;

/**
 * A range in which the values are visible even if a few are a hundred times as large, such as a rate over two nearly
 * equal stamps. Values outside are drawn at the edge and stated as `beyond`. Null without values.
 */
export function shownRange(values: readonly (number | null)[]): Shown | null {
  const known = values.filter((value) => value !== null).sort((a, b) => a - b);
  const [least, greatest] = [known[0], known[known.length - 1]];
  if (least === undefined || greatest === undefined) return null;
  const inner = Math.floor(OUTLIERS * known.length);
  const from = known[inner] ?? least;
  const to = known[known.length - 1 - inner] ?? greatest;
  const room = MARGIN * (to - from);
  const low = to > from ? Math.max(least, from - room) : least;
  const high = to > from ? Math.min(greatest, to + room) : greatest;
  const far = [least, greatest].filter((value) => value < low || value > high);
  const beyond = far.length > 0 ? far.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a)) : null;
  const edge = high > low ? 0.08 * (high - low) : Math.max(0.5, 0.1 * Math.abs(high));
  return { low: low - edge, high: high + edge, beyond };
}

/**
 * The position after a key press: arrow keys move by a hundredth of the interval, with Shift by a tenth, Home and End
 * to its ends.
 */
export function keyedPlace(key: string, shift: boolean, at: number, [from, to]: Span): number | null {
  const step = (to - from) * (shift ? 0.1 : 0.01);
  const moved: Record<string, number> = { ArrowRight: at + step, ArrowLeft: at - step, Home: from, End: to };
  const place = moved[key];
  return place === undefined ? null : Math.min(to, Math.max(from, place));
}

/** An interval around a position, `factor` times as long, within the whole one; null if it would be the whole. */
export function zoomedSpan([from, to]: Span, whole: Span, at: number, factor: number): Span | null {
  const length = (to - from) * factor;
  if (length >= whole[1] - whole[0]) return null;
  const share = to > from ? Math.min(1, Math.max(0, (at - from) / (to - from))) : 0.5;
  const begin = Math.min(whole[1] - length, Math.max(whole[0], at - share * length));
  return [begin, begin + length];
}

/** Decimals of a value, by its unit. */
const PLACES: Record<string, number> = { "%": 0, "m/s": 2, m: 2, s: 2, "rad/s": 2, rad: 2 };

/** A value with its unit: 0.42 m/s. */
export function valueText(column: SeriesColumn, value: number | null | undefined): string {
  return value === null || value === undefined ? "–" : `${written(value, PLACES[column.unit] ?? 3)} ${column.unit}`;
}

/** The interval of all times; for a single one, the second that starts with it. */
export function wholeSpan(times: readonly number[]): Span {
  const from = times[0] ?? 0;
  const to = times[times.length - 1] ?? from;
  return [from, to > from ? to : from + 1];
}
