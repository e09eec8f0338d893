/** The moving table: where it can be placed, and how many beams a cell needs to become free again. */

import { along } from "../../grid/beams";
import { type CellParameters, INITIAL_PARAMETERS, readingsUntil } from "../../grid/sensorModel";
import { FREE } from "../../render/chart/LogOddsBackground";
import type { DrawnSolid, Forgetting, Frame, Values } from "../../wire/protocol";

/** Side of the table and distances of its centre from the robot, metres. */
const SIDE = 0.6;
const DISTANCES = [1.6, 1.3, 1.0];
/** Free space behind the table, so that beams pass through its cells once it is removed; metres. */
const BEHIND = 0.3;
const BEARINGS = 36;

/** A table in front of the robot in free space of the newest scan, as near to straight ahead as possible; or null. */
export function placeOf(frame: Frame): DrawnSolid | null {
  const bearings = Array.from(
    { length: BEARINGS },
    (_, i) => ((i + 1) >> 1) * (i % 2 ? -1 : 1) * ((2 * Math.PI) / BEARINGS),
  );
  for (const distance of DISTANCES) {
    for (const bearing of bearings) {
      if (!isOpen(frame, bearing, distance)) continue;
      const [x, y] = along(frame.scan_pose, bearing, distance);
      const corner = (at: number, half: number): number => Math.round((at + half) * 20) * 5;
      const half = SIDE / 2;
      return ["box", corner(x, -half), corner(y, -half), corner(x, half), corner(y, half)];
    }
  }
  return null;
}

/** Whether every beam that could hit the table, in any orientation of it, has a range beyond it. */
function isOpen(frame: Frame, bearing: number, distance: number): boolean {
  const radius = (SIDE / 2) * Math.SQRT2;
  const half = Math.asin(Math.min(1, (radius + 0.1) / distance));
  let beams = 0;
  for (const [i, range] of frame.ranges.entries()) {
    const off = frame.angle_min + i * frame.angle_increment - bearing;
    if (Math.abs(Math.atan2(Math.sin(off), Math.cos(off))) > half) continue;
    if (range === null || range < distance + radius + BEHIND) return false;
    beams++;
  }
  return beams >= 4;
}

/**
 * Number of misses until a cell at the upper clamp is free. Null if it never becomes free, or if the model does not add
 * log-odds.
 */
export function passesToForget(values: Values): number | null {
  const limits = { log_odds_min: -2, log_odds_max: 3.5 };
  const config: CellParameters = {
    ...INITIAL_PARAMETERS,
    ...limits,
    ...(values as Partial<CellParameters>),
    clamp: true,
  };
  const isSum = config.model !== "moravec_elfes" && config.model !== "hit_counting";
  return isSum ? readingsUntil("miss", config.log_odds_max, FREE, config) : null;
}

/** Why the map without the clamp needs more scans, or fewer. */
export const withoutClamp = (clamped: number, free: number | null): string =>
  free !== null && free < clamped
    ? "Without the clamp it was faster this time: before the table was added, the cells had been observed as free for so long that they hardly became occupied."
    : "Without the clamp, the misses must outweigh all the hits that the table has added.";

export interface Point {
  readonly scans: number;
  readonly withClamp: number;
  readonly without: number;
}

/** The points so far, one for each scan; a new experiment starts a new list. */
export function grown(points: readonly Point[], message: Forgetting): readonly Point[] {
  const last = points.at(-1);
  const point = { scans: message.scans, withClamp: message.free_with_clamp, without: message.free_without_clamp };
  if (message.scans === 0) return [];
  // Both maps have forgotten everything: no more points.
  if (last && last.withClamp >= 1 && last.without >= 1 && message.scans > last.scans) return points;
  if (!last || message.scans > last.scans) return [...points, point];
  return message.scans < last.scans ? [point] : points;
}

/** The quality of a guess in words. */
export function verdict(guess: number, outcome: number): string {
  if (Math.abs(guess - outcome) <= Math.max(2, 0.2 * outcome)) return "You were right.";
  const ratio = Math.max(guess / outcome, outcome / guess);
  const times = Math.round(ratio);
  if (guess < outcome)
    return ratio < 2 ? "It took longer than you thought." : `It took ${times} times as long as you thought.`;
  return ratio < 2 ? "It was quicker than you thought." : `It was ${times} times as quick as you thought.`;
}
