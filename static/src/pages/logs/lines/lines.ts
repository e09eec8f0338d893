/** Log lines of nodes (/rosout, /diagnostics): filter, next match, and marks on the time slider. */

import type { Signal } from "@preact/signals";
import type { TimelineTick } from "../../../ui/Timeline";
import type { LineAnswer } from "../../../wire/http";
import type { Trajectory } from "../../../wire/protocol";
import { scansAt } from "../time/scanTimes";

export type Line = LineAnswer;

/** State shared by the view of the lines, the dock and the time slider. */
export interface LinesState {
  /** Null until they are known. */
  readonly lines: Signal<readonly Line[] | null>;
  readonly failure: Signal<string | null>;
  /** Number of omitted lines. */
  readonly leftOut: Signal<number>;
  /** The minimum level shown. */
  readonly least: Signal<number>;
  /** The node whose lines are shown; "" for all. */
  readonly node: Signal<string>;
  readonly text: Signal<string>;
  /** The line selected last, and the number of scans in the map at its time. */
  readonly chosen: Signal<{ readonly line: Line; readonly scans: number } | null>;
}

export const WARNING = 30;
const ERROR = 40;
/** ROS 2's levels, most severe first. */
export const LEVELS: readonly (readonly [level: number, name: string])[] = [
  [50, "fatal"],
  [ERROR, "error"],
  [WARNING, "warning"],
  [20, "info"],
  [10, "debug"],
];

export const levelName = (level: number): string => LEVELS.find(([least]) => level >= least)?.[1] ?? "debug";

/** The nodes that logged something, by name. */
export const nodesOf = (lines: readonly Line[]): readonly string[] =>
  [...new Set(lines.map(({ name }) => name))].sort((a, b) => a.localeCompare(b));

/** The lines of at least a level, of a node, that contain the text, ignoring case. */
export function matching(lines: readonly Line[], least: number, node: string, text: string): readonly Line[] {
  const searched = text.trim().toLowerCase();
  return lines.filter(
    ({ level, topic, name, text: own }) =>
      level >= least &&
      (node === "" || name === node) &&
      (searched === "" || `${topic} ${name} ${own}`.toLowerCase().includes(searched)),
  );
}

/** The index of the newest line at a time; −1 before the first. */
export function newestAt(lines: readonly Line[], seconds: number): number {
  let low = 0;
  let high = lines.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((lines[middle]?.seconds ?? 0) <= seconds + 5e-4) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Ticks for warnings and above, one at each position of the slider for its most severe line. */
export function ticksOf(
  lines: readonly Line[],
  trajectory: Pick<Trajectory, "stamps" | "every">,
  count: number,
  places = 200,
): readonly TimelineTick[] {
  const gravest = new Map<number, { index: number; level: number }>();
  for (const { level, seconds } of lines) {
    if (level < WARNING) continue;
    const index = scansAt(trajectory, seconds, count);
    const place = Math.round((index / Math.max(1, count)) * places);
    if ((gravest.get(place)?.level ?? 0) < level) gravest.set(place, { index, level });
  }
  return [...gravest.values()].map(({ index, level }) => ({ index, isGrave: level >= ERROR }));
}
