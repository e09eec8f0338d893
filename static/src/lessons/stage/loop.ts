/** Table 9.1 on a coarse grid: the map in the middle of the loop over all cells. */

import type { Cell } from "../../grid/lattice";
import { emptyGrid, INITIAL_CONFIG, type MappingConfig, type OccupancyGrid } from "../../grid/occupancyGrid";
import { bayesFilter, inverseRangeSensorModel, updatePerScan } from "../../grid/textbook";
import { DRIVE, FLOOR } from "./floor";
import { geometryOf, scanAt, USUAL } from "./sensing";

const SIDE = 0.4;
export const LOOP_GEOMETRY = geometryOf(SIDE, FLOOR.width, FLOOR.height);
export const LOOP_CELLS = LOOP_GEOMETRY.rows * LOOP_GEOMETRY.cols;
/** The scan that the loop adds. */
const LOOP_SCAN = 29;
const CONDITIONS = { ...USUAL, reach: 4 };
const CONFIG: MappingConfig = { ...INITIAL_CONFIG, update: "per_scan", window: SIDE, no_return: "free" };

const pose = DRIVE[LOOP_SCAN] ?? [0, 0, 0];

/** ℓ of time t − 1: the map of some scans before. */
const BEFORE: OccupancyGrid = (() => {
  const grid = emptyGrid(LOOP_GEOMETRY);
  for (const i of [21, 24, 26]) {
    const from = DRIVE[i];
    if (from) updatePerScan(grid, scanAt(from, i, CONDITIONS), from, CONFIG);
  }
  return grid;
})();

/** inverse_sensor_model − ℓ₀ of each cell, NaN outside the perceptual field. */
const EVIDENCE = inverseRangeSensorModel(LOOP_GEOMETRY, scanAt(pose, LOOP_SCAN, CONDITIONS), pose, CONFIG);

interface Visit {
  readonly cell: Cell;
  readonly inField: boolean;
  readonly evidence: number;
  readonly before: number;
  readonly after: number;
}

/** What the loop does in its cell number `i`, row by row from below. */
export function visitOf(i: number): Visit {
  const evidence = EVIDENCE[i] ?? Number.NaN;
  const before = BEFORE.logOdds[i] ?? 0;
  const inField = !Number.isNaN(evidence);
  const cell = { row: Math.floor(i / LOOP_GEOMETRY.cols), col: i % LOOP_GEOMETRY.cols };
  return { cell, inField, evidence, before, after: inField ? bayesFilter(before, evidence, CONFIG) : before };
}

/** The map after the first `count` cells. */
export function loopMap(count: number): OccupancyGrid {
  const grid = { ...BEFORE, logOdds: BEFORE.logOdds.slice(), observed: BEFORE.observed.slice() };
  for (let i = 0; i < Math.min(count, LOOP_CELLS); i++) {
    const { inField, after } = visitOf(i);
    if (!inField) continue;
    grid.logOdds[i] = after;
    grid.observed[i] = 1;
  }
  return grid;
}

/** The indices of the cells in the perceptual field. */
export const FIELD: readonly number[] = [...EVIDENCE.keys()].filter((i) => !Number.isNaN(EVIDENCE[i] ?? Number.NaN));
