/** The same scans in cells of different sizes: memory of the whole floor, and the number of updated cells. */

import { emptyGrid, type GridGeometry, INITIAL_CONFIG, type OccupancyGrid } from "../../grid/occupancyGrid";
import { occupancyGridMapping } from "../../grid/textbook";
import { DRIVE, FLOOR } from "../stage/floor";
import { scanAt, USUAL } from "../stage/sensing";

/** Sides of a cell, metres. */
export const SIDES = [0.01, 0.05, 0.1] as const;
const BYTES_PER_CELL = 4;

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
  /** How many cells of the drawn part the beams updated, each time counted. */
  readonly updates: number;
}

export function make(side: number, noise: number): Made {
  const scans = DRIVE.slice(FIRST, LAST).map((pose, i) => ({
    pose,
    scan: scanAt(pose, FIRST + i, { ...USUAL, noise }),
  }));
  const grid = emptyGrid(partOf(side));
  let updates = 0;
  for (const { pose, scan } of scans) updates += occupancyGridMapping(grid, scan, pose, INITIAL_CONFIG);
  return { grid, noise, updates };
}
