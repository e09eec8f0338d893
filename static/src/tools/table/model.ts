/** The moving table: where it can stand, and what the arithmetic of one cell says of how long a map remembers it. */

import { along } from "../../grid/beams";
import { type CellParameters, readingsUntil } from "../../grid/cellUpdate";
import { INITIAL_PARAMETERS } from "../../grid/sensorModel";
import { FREE } from "../../render/chart/LogOddsBackground";
import type { DrawnSolid, Forgetting, Frame, Values } from "../../wire/protocol";

/** Side of the table and how far its middle stands from the robot, metres. */
const SIDE = 0.6;
const DISTANCES = [1.6, 1.3, 1.0];
/** Free space that is left behind the table, so that beams pass where it stood. */
const BEHIND = 0.3;
const BEARINGS = 36;

/** A table before the robot, where the newest scan sees floor all around it: as straight ahead as can be. */
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

/** Whether every beam that would meet the table, wherever it is turned, now sees beyond it. */
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
 * How often a cell at the upper clamp has to be passed until it is free: the arithmetic of one cell. Null where it never
 * is, or where the model keeps no sum.
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

/** Why the map without the clamp took as long as it did, or has not forgotten yet. */
export const withoutClamp = (clamped: number, free: number | null): string =>
  free !== null && free < clamped
    ? "Without the clamp it was quicker this time: before the table came, that map had seen free floor there for so long that it hardly came to believe in the table."
    : "Without the clamp as much has to be argued away as was ever argued for.";

export interface Point {
  readonly scans: number;
  readonly withClamp: number;
  readonly without: number;
}

/** What has been told so far, one point for each scan; a new count begins anew. */
export function grown(points: readonly Point[], told: Forgetting): readonly Point[] {
  const last = points.at(-1);
  const point = { scans: told.scans, withClamp: told.free_with_clamp, without: told.free_without_clamp };
  if (told.scans === 0) return [];
  // When both have forgotten everything there is no more to see.
  if (last && last.withClamp >= 1 && last.without >= 1 && told.scans > last.scans) return points;
  if (!last || told.scans > last.scans) return [...points, point];
  return told.scans < last.scans ? [point] : points;
}

/** How near a guess came, in words. */
export function verdict(guess: number, outcome: number): string {
  if (Math.abs(guess - outcome) <= Math.max(2, 0.2 * outcome)) return "You were right.";
  const ratio = Math.max(guess / outcome, outcome / guess);
  const times = Math.round(ratio);
  if (guess < outcome)
    return ratio < 2 ? "It took longer than you thought." : `It took ${times} times as long as you thought.`;
  return ratio < 2 ? "It was quicker than you thought." : `It was ${times} times as quick as you thought.`;
}
