/**
 * A table is seen for a while and then carried away: how many scans until the map has forgotten it? The scans are
 * taken per scan, so that each adds its evidence to a cell once and the reader can reckon.
 */

import type { Pose } from "../../protocol";
import { cellsOf, stateOf } from "../lesson/counts";
import { CONFIG, copyOf, emptyGrid, indexOf, type LessonGeometry, type LessonGrid } from "../lesson/grid";
import { occupancyGridMapping } from "../lesson/textbook";
import { allRound, box, scanFrom, type Wall } from "../lesson/world";

export const GEOMETRY: LessonGeometry = { resolution: 0.2, rows: 20, cols: 30, origin: [0, 0, 0] };
export const ROOM: readonly Wall[] = box(0.5, 0.5, 5.5, 3.5);
export const TABLE: readonly Wall[] = box(3.1, 1.5, 3.9, 2.5);
export const SENSOR: Pose = [1.53, 2.07, 0];
const LIDAR = allRound(150, 8);

export interface Clamp {
  readonly on: boolean;
  readonly low: number;
  readonly high: number;
}

/** One map through the table's time and after it. */
export interface Story {
  /** The log-odds of the cell that stays occupied longest, before the first scan and after each. */
  readonly path: readonly number[];
  /** Scans after the table went until none of its cells counts as occupied; null where `limit` scans are too few. */
  readonly forgottenAfter: number | null;
  /** The map after scan `i`, 0 … seen + limit. */
  mapAfter(i: number): LessonGrid;
}

const configOf = ({ on, low, high }: Clamp): typeof CONFIG => ({
  ...CONFIG,
  update: "per_scan",
  clamp: on,
  log_odds_min: low,
  log_odds_max: high,
});

/** `seen` scans with the table, then `limit` without it. */
export function tell(seen: number, limit: number, clamp: Clamp): Story {
  const config = configOf(clamp);
  const [withTable, without] = [scanFrom([...ROOM, ...TABLE], SENSOR, LIDAR), scanFrom(ROOM, SENSOR, LIDAR)];
  const grid = emptyGrid(GEOMETRY);
  const values: Float32Array[] = [grid.logOdds.slice()];
  const maps: LessonGrid[] = [copyOf(grid)];
  for (let i = 0; i < seen; i++) {
    occupancyGridMapping(grid, withTable, SENSOR, config);
    values.push(grid.logOdds.slice());
    maps.push(copyOf(grid));
  }
  // The table's cells: those that count as occupied now and that the beams will pass once it is gone.
  const fresh = emptyGrid(GEOMETRY);
  occupancyGridMapping(fresh, without, SENSOR, config);
  const table = cellsOf(grid, "occupied")
    .map((cell) => indexOf(GEOMETRY, cell))
    .filter((index) => (fresh.logOdds[index] ?? 0) < 0);
  let forgottenAfter: number | null = table.length === 0 ? 0 : null;
  let last = table[0] ?? 0;
  for (let i = 1; i <= limit; i++) {
    occupancyGridMapping(grid, without, SENSOR, config);
    values.push(grid.logOdds.slice());
    maps.push(copyOf(grid));
    const left = table.filter((index) => stateOf(grid, index) === "occupied");
    if (left.length > 0) last = left[0] ?? last;
    else forgottenAfter ??= i;
  }
  return {
    path: values.map((one) => one[last] ?? 0),
    forgottenAfter,
    mapAfter: (i) => maps[Math.min(maps.length - 1, Math.max(0, i))] ?? grid,
  };
}
