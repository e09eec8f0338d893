/** The noisy wall of the stage: how thick it is in the map, and how much of it is missing. */

import { cellAt } from "../../grid/lattice";
import type { OccupancyGrid } from "../../grid/occupancyGrid";
import { stateOf } from "../common/counts";

export type Look = "thin" | "torn" | "fat";

export interface WallLook {
  readonly look: Look;
  /** Mean number of occupied cells across the wall, where there is one. */
  readonly thickness: number;
  /** Fraction of the columns without an occupied cell. */
  readonly gaps: number;
}

/** The stretch of the wall that is looked at, metres. */
export const STRETCH = { from: 4.7, to: 6.6, y: 3.235, reach: 0.6 } as const;
/** More gaps than this are torn; more occupied cells across than this are fat. */
const TORN = 0.08;
const FAT = 4;

export function lookOfWall(grid: OccupancyGrid): WallLook {
  const { geometry } = grid;
  const first = cellAt(geometry, STRETCH.from, STRETCH.y - STRETCH.reach);
  const last = cellAt(geometry, STRETCH.to, STRETCH.y + STRETCH.reach);
  const counts: number[] = [];
  for (let col = first.col; col <= last.col; col++) {
    let occupied = 0;
    for (let row = first.row; row <= last.row; row++)
      if (stateOf(grid, row * geometry.cols + col) === "occupied") occupied++;
    counts.push(occupied);
  }
  const there = counts.filter((count) => count > 0);
  const gaps = 1 - there.length / counts.length;
  const thickness = there.reduce((sum, count) => sum + count, 0) / Math.max(1, there.length);
  return { look: gaps > TORN ? "torn" : thickness > FAT ? "fat" : "thin", thickness, gaps };
}
