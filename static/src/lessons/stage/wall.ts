/** The noisy wall of the stage: how thick it is in the map, and how much of it is missing. */

import { cellAt } from "../../grid/lattice";
import type { OccupancyGrid } from "../../grid/occupancyGrid";
import { stateOf } from "../common/counts";

export type Look = "thin" | "broken" | "thick";

interface WallLook {
  readonly look: Look;
  /** Mean number of occupied cells across the wall, where there is one. */
  readonly thickness: number;
  /** Fraction of the columns in which the wall has a hole, is missing, or jumps by two cells or more. */
  readonly broken: number;
}

/** The stretch of the wall that is looked at, metres. */
export const STRETCH = { from: 4.7, to: 6.6, y: 3.235, reach: 0.6 } as const;
/** A wall is broken if it is so in more than this fraction of its columns, and thick if more cells than this are across. */
const BROKEN = 0.15;
const THICK = 5;

export function lookOfWall(grid: OccupancyGrid): WallLook {
  const { geometry } = grid;
  const first = cellAt(geometry, STRETCH.from, STRETCH.y - STRETCH.reach);
  const last = cellAt(geometry, STRETCH.to, STRETCH.y + STRETCH.reach);
  let [broken, occupied, there, columns] = [0, 0, 0, 0];
  let before: number | null = null;
  for (let col = first.col; col <= last.col; col++, columns++) {
    const rows: number[] = [];
    for (let row = first.row; row <= last.row; row++)
      if (stateOf(grid, row * geometry.cols + col) === "occupied") rows.push(row);
    const [low, high] = [rows[0], rows.at(-1)];
    if (low === undefined || high === undefined) {
      broken++;
      continue;
    }
    const jumps = before !== null && Math.abs(low - before) >= 2;
    if (high - low + 1 > rows.length || jumps) broken++;
    before = low;
    occupied += rows.length;
    there++;
  }
  const thickness = occupied / Math.max(1, there);
  const fraction = broken / columns;
  return { look: thickness > THICK ? "thick" : fraction > BROKEN ? "broken" : "thin", thickness, broken: fraction };
}
