/** Cells of a map by state, and the occupied cells where no wall is. */

import { logOdds } from "../../grid/cellValues";
import { type Cell, centreOf } from "../../grid/lattice";
import type { OccupancyGrid } from "../../grid/occupancyGrid";
import { FREE_THRESHOLD, OCCUPIED_THRESHOLD } from "../../wire/constants";
import { distanceTo, type Wall } from "./world";

export type State = "free" | "unknown" | "occupied";

const OCCUPIED = logOdds(OCCUPIED_THRESHOLD);
const FREE = logOdds(FREE_THRESHOLD);

/** The three-way state of a cell, as the mapper classifies it. */
export function stateOf(grid: OccupancyGrid, index: number): State {
  if (grid.observed[index] !== 1) return "unknown";
  const value = grid.logOdds[index] ?? 0;
  return value > OCCUPIED ? "occupied" : value < FREE ? "free" : "unknown";
}

export function cellsOf(grid: OccupancyGrid, state: State): readonly Cell[] {
  const { rows, cols } = grid.geometry;
  return Array.from({ length: rows * cols }, (_, index) => index)
    .filter((index) => stateOf(grid, index) === state)
    .map((index) => ({ row: Math.floor(index / cols), col: index % cols }));
}

/** Occupied cells whose centre is farther than `reach` metres from every wall. */
export function phantoms(grid: OccupancyGrid, walls: readonly Wall[], reach: number): readonly Cell[] {
  return cellsOf(grid, "occupied").filter((cell) => distanceTo(centreOf(grid.geometry, cell), walls) > reach);
}
