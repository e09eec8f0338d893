/** Grids, scans and parameters of the lecture's figures; names as in the mapper. */

import type { Pose } from "../wire/protocol";
import type { Cell } from "./lattice";

export interface GridGeometry {
  /** Side of a cell, metres. */
  readonly resolution: number;
  readonly rows: number;
  readonly cols: number;
  readonly origin: Pose;
}

/** Log-odds (float32, as the mapper keeps them), row 0 at the smallest y, and which cells were ever observed. */
export interface OccupancyGrid {
  readonly geometry: GridGeometry;
  readonly logOdds: Float32Array;
  readonly observed: Uint8Array;
  /** Of models that keep two numbers for each cell: hits and misses, or how certainly it is occupied and empty. */
  readonly statistics?: CellStatistics | null;
}

export type CellStatistics = readonly [occupied: Float32Array, free: Float32Array];

export interface LaserScan {
  /** Metres, kept as float32; Infinity is no return (REP 117). */
  readonly ranges: Float32Array;
  readonly angle_min: number;
  readonly angle_increment: number;
  readonly range_min: number;
  readonly range_max: number;
}

/** The rows of the mapper's parameter table that a figure may vary. */
export interface MappingConfig {
  readonly range_max: number;
  readonly window: number;
  /** A smooth ramp in place of the window: of the standard deviation σ + growth · z, metres. */
  readonly ramp?: { readonly sigma: number; readonly growth: number } | null;
  /** Hits and misses are counted in place of adding evidence; the prior weighs as this many visits. */
  readonly prior_weight?: number | null;
  readonly log_odds_hit: number;
  readonly log_odds_miss: number;
  readonly update: "per_beam" | "per_scan";
  readonly traversal: "bresenham" | "amanatides_woo";
  readonly no_return: "ignore" | "free" | "hit";
  readonly clamp: boolean;
  readonly log_odds_min: number;
  readonly log_odds_max: number;
  readonly log_odds_prior: number;
}

/** The table's default values; tested against the mapper's with the vectors. */
export const INITIAL_CONFIG: Omit<MappingConfig, "ramp" | "prior_weight"> = {
  range_max: 30,
  window: 0,
  log_odds_hit: 0.85,
  log_odds_miss: -0.4,
  update: "per_beam",
  traversal: "bresenham",
  no_return: "ignore",
  clamp: true,
  log_odds_min: -2,
  log_odds_max: 3.5,
  log_odds_prior: 0,
};

export function emptyGrid(geometry: GridGeometry, prior = 0): OccupancyGrid {
  const count = geometry.rows * geometry.cols;
  return { geometry, logOdds: new Float32Array(count).fill(prior), observed: new Uint8Array(count) };
}

/** An empty grid that has statistics of each cell, 0 at first. */
export function emptyStatistics(
  geometry: GridGeometry,
  prior = 0,
): OccupancyGrid & { readonly statistics: CellStatistics } {
  const grid = emptyGrid(geometry, prior);
  const { length } = grid.logOdds;
  return { ...grid, statistics: [new Float32Array(length), new Float32Array(length)] };
}

/** The statistics of a grid. Throws a TypeError for one that has none. */
export function statisticsOf({ statistics }: OccupancyGrid): CellStatistics {
  if (!statistics) throw new TypeError("This grid keeps no statistics of its cells.");
  return statistics;
}

export const copyOf = (grid: OccupancyGrid): OccupancyGrid => ({
  geometry: grid.geometry,
  logOdds: grid.logOdds.slice(),
  observed: grid.observed.slice(),
  statistics: grid.statistics ? [grid.statistics[0].slice(), grid.statistics[1].slice()] : null,
});

/** Index of a cell in the arrays; −1 outside the grid. */
export function indexOf({ rows, cols }: GridGeometry, { row, col }: Cell): number {
  return row >= 0 && col >= 0 && row < rows && col < cols ? row * cols + col : -1;
}
