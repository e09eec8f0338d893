/** The geometry of the exploded view: sheets above each other, each a parallelogram of the same cells. */

import type { Cell } from "../../grid/lattice";
import type { Point } from "../../wire/protocol";

/** Shift of a row to the right, and its height, as shares of a column's width. */
const LEAN = 0.45;
const FLAT = 0.4;

/** The cells that the sheets show. */
export interface Window {
  readonly row0: number;
  readonly rows: number;
  readonly col0: number;
  readonly cols: number;
}

export interface SheetPlan {
  readonly window: Window;
  /** Pixels of a column. */
  readonly scale: number;
  /** The lower left corner of each sheet, from the bottom one up, px. */
  readonly corners: readonly Point[];
  /** Height of a sheet, px. */
  readonly height: number;
}

/** Sheets as wide as the picture, separated by `gaps` px, the lowest at the bottom. */
export function sheetPlan(window: Window, width: number, height: number, gaps: readonly number[]): SheetPlan {
  const most = (height - sum(gaps)) / (FLAT * window.rows);
  const scale = Math.max(0.1, Math.min(width / (window.cols + LEAN * window.rows), most));
  const left = (width - scale * (window.cols + LEAN * window.rows)) / 2;
  let y = height - 1;
  const corners: Point[] = [[left, y]];
  for (const gap of gaps) {
    y -= gap;
    corners.push([left, y]);
  }
  return { window, scale, corners, height: FLAT * scale * window.rows };
}

const sum = (values: readonly number[]): number => values.reduce((a, b) => a + b, 0);

/** The transform of a canvas in which a cell of the grid is a square of side 1, row 0 at the bottom. */
export function transformOf(
  { scale, window }: SheetPlan,
  [x, y]: Point,
): readonly [number, number, number, number, number, number] {
  const [c, d] = [LEAN * scale, -FLAT * scale];
  return [scale, 0, c, d, x - scale * window.col0 - c * window.row0, y - d * window.row0];
}

/** The position of a point in cells (column, row) on a sheet. */
export function placeOn(plan: SheetPlan, corner: Point, u: number, v: number): Point {
  const [a, , c, d, e, f] = transformOf(plan, corner);
  return [a * u + c * v + e, d * v + f];
}

/** The indices of the sheets in painting order: from the bottom up, the one in front last. */
export function paintOrder(count: number, front: number | null): readonly number[] {
  const others = Array.from({ length: count }, (_, n) => n).filter((n) => n !== front);
  return front === null ? others : [...others, front];
}

/** The topmost sheet at a place of the picture, and the cell there; null outside of all sheets. */
export function cellOn(plan: SheetPlan, x: number, y: number): { readonly sheet: number; readonly cell: Cell } | null {
  const { row0, rows, col0, cols } = plan.window;
  for (let sheet = plan.corners.length - 1; sheet >= 0; sheet--) {
    const [a, , c, d, e, f] = transformOf(plan, plan.corners[sheet] as Point);
    const v = (y - f) / d;
    const u = (x - e - c * v) / a;
    if (u >= col0 && u < col0 + cols && v >= row0 && v < row0 + rows)
      return { sheet, cell: { row: Math.floor(v), col: Math.floor(u) } };
  }
  return null;
}

/** The gaps after the sheet `n` was dragged up by `by` px from the gaps `before`, within the available room. */
export function draggedGaps(before: readonly number[], n: number, by: number, most: number): readonly number[] {
  const room = most - sum(before.filter((_, i) => i !== n - 1));
  return before.map((gap, i) =>
    i === n - 1 ? Math.min(Math.max(gap + by, LEAST_GAP), Math.max(LEAST_GAP, room)) : gap,
  );
}

export const LEAST_GAP = 30; // the names of the sheets do not overlap
