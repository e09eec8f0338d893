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

export interface Fixes {
  /** Step with the signs of the differences. */
  readonly direction: boolean;
  /** Swap the axes of a line that rises more than it runs. */
  readonly steep: boolean;
}

interface LineStep {
  readonly cell: Cell;
  /** ∇ in this cell, which decides the next step; null in the last cell. */
  readonly nabla: number | null;
}

export interface Line {
  readonly steps: readonly LineStep[];
  /** The longer and the shorter difference, as the algorithm took them. */
  readonly dx: number;
  readonly dy: number;
  readonly steep: boolean;
}

/**
 * The line step by step, with the error term ∇, and without one or both of the fixes that extend it from the first
 * octant to all eight. With both it is the line of {@link bresenham}.
 */
export function bresenhamSteps(start: Cell, end: Cell, fixes: Fixes): Line {
  const size = (difference: number): number => (fixes.direction ? Math.abs(difference) : difference);
  const sign = (difference: number): number => (fixes.direction && difference < 0 ? -1 : 1);
  const [dRow, dCol] = [end.row - start.row, end.col - start.col];
  const steep = fixes.steep && size(dRow) > size(dCol);
  const [dx, dy] = steep ? [size(dRow), size(dCol)] : [size(dCol), size(dRow)];
  let { row, col } = start;
  let nabla = 2 * dy - dx;
  const steps: LineStep[] = [];
  for (let i = 0; i < dx; i++) {
    steps.push({ cell: { row, col }, nabla });
    const diagonal = nabla >= 0;
    if (steep || diagonal) row += sign(dRow);
    if (!steep || diagonal) col += sign(dCol);
    nabla += diagonal ? 2 * dy - 2 * dx : 2 * dy;
  }
  steps.push({ cell: { row, col }, nabla: null });
  return { steps, dx, dy, steep };
}

/** The octant of a line's direction, 1 … 8 counter-clockwise from +x. */
export function octant(start: Cell, end: Cell): number {
  const angle = Math.atan2(end.row - start.row, end.col - start.col);
  return (Math.floor((angle + 2 * Math.PI) / (Math.PI / 4)) % 8) + 1;
}
