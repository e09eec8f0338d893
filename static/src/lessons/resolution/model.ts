/** The same scans in cells of different sizes: memory of the whole floor, and the time of the update. */

import { emptyGrid, type GridGeometry, INITIAL_CONFIG, type OccupancyGrid } from "../../grid/occupancyGrid";
import { occupancyGridMapping } from "../../grid/textbook";
import { DRIVE, FLOOR } from "../stage/floor";
import { scanAt, USUAL } from "../stage/sensing";

/** Sides of a cell, metres. */
export const SIDES = [0.01, 0.05, 0.1] as const;
const BYTES_PER_CELL = 4;
/** The first run of a program in a browser is slower than the others. */
const RUNS = 3;

/** The part of the floor that is drawn, metres: a door and the pillar behind it. */
const PART = { x: 6.9, y: 1.2, width: 3.2, height: 2.4 } as const;
const FIRST = 28;
const LAST = 40;
export const SCANS = LAST - FIRST;

const partOf = (side: number): GridGeometry => ({
  resolution: side,
  rows: Math.round(PART.height / side),
  cols: Math.round(PART.width / side),
  origin: [PART.x, PART.y, 0],
});

/** Number of cells of the whole floor, and their bytes. */
export function sizeOf(side: number): { readonly cells: number; readonly bytes: number } {
  const cells = Math.round(FLOOR.width / side) * Math.round(FLOOR.height / side);
  return { cells, bytes: BYTES_PER_CELL * cells };
}

export interface Made {
  readonly grid: OccupancyGrid;
  readonly noise: number;
  /** How long the update took here, milliseconds: the least of some runs. */
  readonly ms: number;
}

export function make(side: number, noise: number): Made {
  const scans = DRIVE.slice(FIRST, LAST).map((pose, i) => ({
    pose,
    scan: scanAt(pose, FIRST + i, { ...USUAL, noise }),
  }));
  let [grid, ms] = [emptyGrid(partOf(side)), Number.POSITIVE_INFINITY];
  for (let run = 0; run < RUNS; run++) {
    grid = emptyGrid(partOf(side));
    const start = performance.now();
    for (const { pose, scan } of scans) occupancyGridMapping(grid, scan, pose, INITIAL_CONFIG);
    ms = Math.min(ms, performance.now() - start);
  }
  return { grid, noise, ms };
}
