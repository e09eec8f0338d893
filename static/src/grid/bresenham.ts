/** Bresenham's line, as in `mapper/mapping/textbook_traversal.py`; tested with vectors from there. */

import type { Cell } from "./lattice";

/** Call `visit` with each cell of the line from `start` to `end`, both included, until it returns false. */
export function bresenham(start: Cell, end: Cell, visit: (row: number, col: number) => boolean | undefined): void {
  const stepRow = end.row >= start.row ? 1 : -1;
  const stepCol = end.col >= start.col ? 1 : -1;
  const dRow = Math.abs(end.row - start.row);
  const dCol = Math.abs(end.col - start.col);
  const steep = dRow > dCol;
  const a = steep ? dRow : dCol;
  const b = steep ? dCol : dRow;
  let { row, col } = start;
  if (visit(row, col) === false) return;
  let nabla = 2 * b - a;
  for (let i = 0; i < a; i++) {
    const diagonal = nabla >= 0;
    if (steep || diagonal) row += stepRow;
    if (!steep || diagonal) col += stepCol;
    nabla += diagonal ? 2 * b - 2 * a : 2 * b;
    if (visit(row, col) === false) return;
  }
}
