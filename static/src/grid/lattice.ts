/** World and cell coordinates, as `GridGeometry` in mapper/grid/occupancy_grid.py; tested with vectors from there. */

import type { Geometry, Point, Pose } from "../wire/protocol";

/** A box in world metres: x0, y0, x1, y1. */
export type Bounds = readonly [x0: number, y0: number, x1: number, y1: number];

/** The smallest box around two. */
export const around = (a: Bounds, b: Bounds): Bounds => [
  Math.min(a[0], b[0]),
  Math.min(a[1], b[1]),
  Math.max(a[2], b[2]),
  Math.max(a[3], b[3]),
];

export interface Cell {
  readonly row: number;
  readonly col: number;
}

type Lattice = Pick<Geometry, "origin" | "resolution">;

/** Lattice coordinates (column, row) of a world point, in cells, not floored. */
export function toLattice({ origin, resolution }: Lattice, x: number, y: number): Point {
  const dx = x - origin[0];
  const dy = y - origin[1];
  const yaw = origin[2];
  if (yaw === 0) return [dx / resolution, dy / resolution];
  const c = Math.cos(yaw);
  const s = Math.sin(yaw);
  return [(c * dx + s * dy) / resolution, (c * dy - s * dx) / resolution];
}

/** The world point at lattice coordinates (column, row). */
export function fromLattice({ origin, resolution }: Lattice, u: number, v: number): Point {
  const c = Math.cos(origin[2]);
  const s = Math.sin(origin[2]);
  return [origin[0] + (c * u - s * v) * resolution, origin[1] + (s * u + c * v) * resolution];
}

/** The cell that contains a world point; it may lie outside the grid. */
export function cellAt(lattice: Lattice, x: number, y: number): Cell {
  const [u, v] = toLattice(lattice, x, y);
  return { row: Math.floor(v), col: Math.floor(u) };
}

/** The centre of a cell in the world. */
export function centreOf(lattice: Lattice, cell: Cell): Point {
  return fromLattice(lattice, cell.col + 0.5, cell.row + 0.5);
}

export function contains(geometry: Geometry, { row, col }: Cell): boolean {
  return row >= 0 && col >= 0 && row < geometry.rows && col < geometry.cols;
}

/** The box around the whole grid. */
export const extent = (geometry: Geometry): Bounds => boxAround(geometry, 0, 0, geometry.rows, geometry.cols);

/** The box around the cells of rows `row0` to below `row1` and columns `col0` to below `col1`. */
export function boxAround(lattice: Lattice, row0: number, col0: number, row1: number, col1: number): Bounds {
  const corners = [
    fromLattice(lattice, col0, row0),
    fromLattice(lattice, col1, row0),
    fromLattice(lattice, col0, row1),
    fromLattice(lattice, col1, row1),
  ];
  const xs = corners.map((corner) => corner[0]);
  const ys = corners.map((corner) => corner[1]);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

/** `T_a_b ∘ T_b_c`: the pose of c in a. */
export function compose(a: Pose, b: Pose): Pose {
  const c = Math.cos(a[2]);
  const s = Math.sin(a[2]);
  return [a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]];
}
