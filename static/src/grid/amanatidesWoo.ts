/** The traversal of Amanatides and Woo, as in `mapper/mapping/textbook_traversal.py`; tested with vectors from there. */

import type { Point } from "../wire/protocol";
import type { Cell } from "./lattice";

/** Every cell that the segment crosses, in order. The points are lattice coordinates (column, row), in cells. */
export function amanatidesWoo(start: Point, end: Point): Cell[] {
  const [u, v] = start;
  const [du, dv] = [end[0] - u, end[1] - v];
  let [col, row] = [Math.floor(u), Math.floor(v)];
  const [endCol, endRow] = [Math.floor(end[0]), Math.floor(end[1])];
  const stepRow = endRow >= row ? 1 : -1;
  const stepCol = endCol >= col ? 1 : -1;
  const cells = [{ row, col }];
  while (row !== endRow || col !== endCol) {
    const tRow = row === endRow ? Number.POSITIVE_INFINITY : ((stepRow > 0 ? row + 1 : row) - v) / dv;
    const tCol = col === endCol ? Number.POSITIVE_INFINITY : ((stepCol > 0 ? col + 1 : col) - u) / du;
    if (tCol < tRow) col += stepCol;
    else row += stepRow;
    cells.push({ row, col });
  }
  return cells;
}
