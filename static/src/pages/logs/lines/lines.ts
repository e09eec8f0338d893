/** Lines that nodes logged (/rosout, /diagnostics): which are shown, the next match, and marks on the time slider. */

import type { Signal } from "@preact/signals";
import type { TimelineTick } from "../../../ui/Timeline";
import type { LineAnswer } from "../../../wire/http";
import type { Trajectory } from "../../../wire/protocol";
import { scansAt } from "../time/scanTimes";

export type Line = LineAnswer;

/** What the view of the lines, the dock and the time slider share. */
export interface LinesState {
  /** Null until they are known. */
  readonly lines: Signal<readonly Line[] | null>;
  readonly failure: Signal<string | null>;
  /** Number of lines that are not kept. */
  readonly leftOut: Signal<number>;
  /** The least level that is shown. */
  readonly least: Signal<number>;
  /** The node whose lines are shown; "" for all. */
  readonly node: Signal<string>;
  readonly text: Signal<string>;
  /** The line that was gone to last, and the number of scans in the map at it. */
  readonly chosen: Signal<{ readonly line: Line; readonly scans: number } | null>;
}

export const WARNING = 30;
const ERROR = 40;
/** Levels as ROS 2 has them, from the gravest. */
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

/** The lines of a level or a graver one, of a node, which contain the text, in either case of letters. */
export function matching(lines: readonly Line[], least: number, node: string, text: string): readonly Line[] {
  const searched = text.trim().toLowerCase();
  return lines.filter(
    ({ level, topic, name, text: own }) =>
      level >= least &&
      (node === "" || name === node) &&
      (searched === "" || `${topic} ${name} ${own}`.toLowerCase().includes(searched)),
  );
}

/** The place of the line that is newest at a moment; −1 before the first. */
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

/** Ticks for warnings and for what is graver, one for each place of the slider: of the gravest line there. */
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
