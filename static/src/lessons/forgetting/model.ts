/**
 * A table is seen for some scans and then removed: how many scans until the map has forgotten it? The map is updated
 * per scan, so that each scan adds its evidence to a cell once and the reader can compute the result.
 */

import {
  copyOf,
  emptyGrid,
  type GridGeometry,
  INITIAL_CONFIG,
  indexOf,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import { inverseRangeSensorModel, putIntoCells } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { cellsOf, stateOf } from "../common/counts";
import { allRound, box, scanFrom, type Wall } from "../common/world";

export const GEOMETRY: GridGeometry = { resolution: 0.2, rows: 20, cols: 30, origin: [0, 0, 0] };
export const ROOM: readonly Wall[] = box(0.5, 0.5, 5.5, 3.5);
export const TABLE: readonly Wall[] = box(3.1, 1.5, 3.9, 2.5);
export const SENSOR: Pose = [1.53, 2.07, 0];
const LIDAR = allRound(150, 8);
/** Share of the table's cells that have to be free: as in `mapper/simulation/second_map.py`. */
const MOST = 0.9;

/** The evidence of a scan for each cell, with the table and without; the robot stands still, so it is constant. */
const [WITH_TABLE, WITHOUT] = [[...ROOM, ...TABLE], ROOM].map((walls) =>
  inverseRangeSensorModel(GEOMETRY, scanFrom(walls, SENSOR, LIDAR), SENSOR, INITIAL_CONFIG),
) as [Float64Array, Float64Array];

export interface Clamp {
  readonly on: boolean;
  readonly low: number;
  readonly high: number;
}

/** One map over the scans with the table and without it. */
export interface MapHistory {
  /** The log-odds of the cell that becomes free last, before the first scan and after each. */
  readonly path: readonly number[];
  /** Scans without the table until nine in ten of its cells are free, as in the lab; null if `limit` are too few. */
  readonly forgottenAfter: number | null;
  /** The map after scan `i`, 0 … seen + limit. */
  mapAfter(i: number): OccupancyGrid;
}

const configOf = ({ on, low, high }: Clamp): typeof INITIAL_CONFIG => ({
  ...INITIAL_CONFIG,
  clamp: on,
  log_odds_min: low,
  log_odds_max: high,
});

/** `seen` scans with the table, then `limit` without it. */
export function simulateRemoval(seen: number, limit: number, clamp: Clamp): MapHistory {
  const config = configOf(clamp);
  const grid = emptyGrid(GEOMETRY);
  const maps: OccupancyGrid[] = [copyOf(grid)];
  for (let i = 0; i < seen; i++) {
    putIntoCells(grid, WITH_TABLE, config);
    maps.push(copyOf(grid));
  }
  // The table's cells: those that count as occupied now and that the beams will pass once it is gone.
  const table = cellsOf(grid, "occupied")
    .map((cell) => indexOf(GEOMETRY, cell))
    .filter((index) => (WITHOUT[index] ?? 0) < 0);
  let forgottenAfter: number | null = table.length === 0 ? 0 : null;
  let last = table[0] ?? 0;
  for (let i = 1; i <= limit; i++) {
    putIntoCells(grid, WITHOUT, config);
    maps.push(copyOf(grid));
    const left = table.filter((index) => stateOf(grid, index) !== "free");
    if (left.length > (1 - MOST) * table.length) last = left[0] ?? last;
    else forgottenAfter ??= i;
  }
  return {
    path: maps.map((map) => map.logOdds[last] ?? 0),
    forgottenAfter,
    mapAfter: (i) => maps[Math.min(maps.length - 1, Math.max(0, i))] ?? grid,
  };
}
