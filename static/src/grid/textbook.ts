/**
 * Occupancy grid mapping, as in `mapper/mapping/textbook.py`, with the same functions and names; tested with vectors
 * that the mapper writes (textbook.vectors.json). Source: Probabilistic Robotics, tables 4.2, 9.1 and 9.2.
 */

import type { Point, Pose } from "../wire/protocol";
import { bresenham } from "./bresenham";
import { probability } from "./cellValues";
import { type Cell, toLattice } from "./lattice";
import {
  type GridGeometry,
  indexOf,
  type LaserScan,
  type MappingConfig,
  type OccupancyGrid,
  statisticsOf,
} from "./occupancyGrid";
import { smoothRamp } from "./sensorModel";

/**
 * Every cell that the segment crosses, in order, as in `mapper/mapping/textbook_traversal.py`; tested with vectors from
 * there. The points are lattice coordinates (column, row), in cells.
 */
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

/** The evidence of one beam for a cell, log-odds. */
export interface Evidence {
  readonly cell: Cell;
  readonly evidence: number;
}

const f32 = Math.fround;

export function bayesFilter(
  logOdds: number,
  evidence: number,
  config: Pick<MappingConfig, "clamp" | "log_odds_min" | "log_odds_max">,
): number {
  const sum = f32(logOdds + f32(evidence));
  if (!config.clamp) return sum;
  return Math.min(Math.max(sum, f32(config.log_odds_min)), f32(config.log_odds_max));
}

/** Add evidence to one cell; return the number of updated cells: 1, or 0 outside the grid. */
export function update(grid: OccupancyGrid, cell: Cell, evidence: number, config: MappingConfig): number {
  const index = indexOf(grid.geometry, cell);
  if (index < 0) return 0;
  grid.logOdds[index] = bayesFilter(grid.logOdds[index] ?? 0, evidence, config);
  grid.observed[index] = 1;
  return 1;
}

/** Update `grid` with one scan; return the number of cell updates. */
export function occupancyGridMapping(grid: OccupancyGrid, scan: LaserScan, pose: Pose, config: MappingConfig): number {
  if (config.prior_weight) return countHitsAndMisses(grid, scan, pose, config, config.prior_weight);
  return config.update === "per_scan"
    ? updatePerScan(grid, scan, pose, config)
    : updatePerBeam(grid, scan, pose, config);
}

export const bearingOf = (scan: LaserScan, beam: number): number => scan.angle_min + scan.angle_increment * beam;

export function updatePerBeam(grid: OccupancyGrid, scan: LaserScan, pose: Pose, config: MappingConfig): number {
  let updates = 0;
  scan.ranges.forEach((_, beam) => {
    for (const { cell, evidence } of evidenceOfBeam(grid.geometry, scan, beam, pose, config))
      updates += update(grid, cell, evidence, config);
  });
  return updates;
}

/**
 * Count for each cell the beams that end in it and those that pass it; its log-odds become those of the posterior mean
 * (n + w·p₀) / (n + m + w) for n hits, m misses and the prior's weight w. The cells are those of fixed increments.
 */
function countHitsAndMisses(
  grid: OccupancyGrid,
  scan: LaserScan,
  pose: Pose,
  config: MappingConfig,
  weight: number,
): number {
  const [hits, misses] = statisticsOf(grid);
  const prior = probability(config.log_odds_prior);
  const counting = { ...config, log_odds_hit: 1, log_odds_miss: -1 };
  const visit = (index: number, isHit: boolean): number => {
    if (index < 0) return 0;
    const counts = isHit ? hits : misses;
    counts[index] = (counts[index] ?? 0) + 1;
    const odds = ((hits[index] ?? 0) + weight * prior) / ((misses[index] ?? 0) + weight * (1 - prior));
    grid.logOdds[index] = bayesFilter(0, Math.log(odds), config);
    grid.observed[index] = 1;
    return 1;
  };
  let visits = 0;
  if (config.update === "per_scan")
    inverseRangeSensorModel(grid.geometry, scan, pose, counting).forEach((kind, index) => {
      if (!Number.isNaN(kind)) visits += visit(index, kind > 0);
    });
  else
    scan.ranges.forEach((_, beam) => {
      for (const { cell, evidence } of evidenceOfBeam(grid.geometry, scan, beam, pose, counting))
        visits += visit(indexOf(grid.geometry, cell), evidence > 0);
    });
  return visits;
}

/** The range of a beam; with the setting no return as a hit (an error) z_max for a beam without a return. */
export function readingOf(scan: LaserScan, beam: number, config: MappingConfig): number {
  const z = scan.ranges[beam] ?? Number.NaN;
  const zMax = Math.min(scan.range_max, config.range_max);
  if (config.no_return !== "hit" || !(z > zMax)) return z;
  const nearest = Float32Array.of(zMax);
  // Ranges are float32, and no reading may lie beyond z_max.
  if ((nearest[0] ?? 0) > zMax) new Uint32Array(nearest.buffer)[0] = (new Uint32Array(nearest.buffer)[0] ?? 1) - 1;
  return nearest[0] ?? zMax;
}

/** The evidence of one beam for each cell: of a reading, of no return, or none (too near, NaN, −Infinity). */
export function evidenceOfBeam(
  geometry: GridGeometry,
  scan: LaserScan,
  beam: number,
  pose: Pose,
  config: MappingConfig,
): readonly Evidence[] {
  const z = readingOf(scan, beam, config);
  const bearing = bearingOf(scan, beam);
  const zMax = Math.min(scan.range_max, config.range_max);
  if (scan.range_min <= z && z <= zMax) return evidenceAlongBeam(geometry, pose, bearing, z, config);
  if (z > zMax && config.no_return === "free")
    return cellsAlong(geometry, pose, bearing, zMax, config).map((cell) => ({ cell, evidence: config.log_odds_miss }));
  return [];
}

/**
 * The evidence of a reading `z` for each cell on its beam: free before the window, occupied in it and at the endpoint.
 */
function evidenceAlongBeam(
  geometry: GridGeometry,
  pose: Pose,
  bearing: number,
  z: number,
  config: MappingConfig,
): readonly Evidence[] {
  const { ramp } = config;
  const half = ramp ? 2 * (ramp.sigma + ramp.growth * z) : config.window / 2;
  const model = { hit: config.log_odds_hit, miss: config.log_odds_miss };
  const end = cellOfBeam(geometry, pose, bearing, z);
  const updates: Evidence[] = [];
  let endFound = false;
  for (const cell of cellsAlong(geometry, pose, bearing, z + half, config)) {
    const isEnd = cell.row === end.row && cell.col === end.col;
    const r = half === 0 ? 0 : distance(geometry, pose, cell);
    if (isEnd) updates.push({ cell, evidence: config.log_odds_hit });
    else if (half === 0 || r < z - half) updates.push({ cell, evidence: config.log_odds_miss });
    else if (r <= z + half)
      updates.push({ cell, evidence: ramp ? smoothRamp(r, z, half, model) : config.log_odds_hit });
    endFound ||= isEnd;
  }
  if (!endFound) updates.push({ cell: end, evidence: config.log_odds_hit });
  return updates;
}

/** The cells that a beam crosses up to the distance `z`, in order. */
export function cellsAlong(
  geometry: GridGeometry,
  pose: Pose,
  bearing: number,
  z: number,
  config: Pick<MappingConfig, "traversal">,
): readonly Cell[] {
  const [from, to] = [pointAt(geometry, pose, bearing, 0), pointAt(geometry, pose, bearing, z)];
  if (config.traversal === "amanatides_woo") return amanatidesWoo(from, to);
  const cells: Cell[] = [];
  bresenham(floored(from), floored(to), (row, col) => {
    cells.push({ row, col });
    return true;
  });
  return cells;
}

/** Update every cell in the scan's perceptual field once: table 9.1. */
export function updatePerScan(grid: OccupancyGrid, scan: LaserScan, pose: Pose, config: MappingConfig): number {
  return putIntoCells(grid, inverseRangeSensorModel(grid.geometry, scan, pose, config), config);
}

/** Add the evidence of a scan to each cell; NaN is no evidence. Return the number of updates. */
export function putIntoCells(grid: OccupancyGrid, evidence: Float64Array, config: MappingConfig): number {
  let updates = 0;
  evidence.forEach((value, index) => {
    if (Number.isNaN(value)) return;
    grid.logOdds[index] = bayesFilter(grid.logOdds[index] ?? 0, value, config);
    grid.observed[index] = 1;
    updates++;
  });
  return updates;
}

/** The evidence of a scan for each cell, NaN outside the perceptual field: table 9.2. */
export function inverseRangeSensorModel(
  geometry: GridGeometry,
  scan: LaserScan,
  pose: Pose,
  config: MappingConfig,
): Float64Array {
  const { rows, cols, resolution } = geometry;
  const w = config.window;
  const zMax = Math.min(scan.range_max, config.range_max);
  const updates = new Float64Array(rows * cols).fill(Number.NaN);
  const [col0, row0] = toLattice(geometry, pose[0], pose[1]);
  const heading = pose[2] - geometry.origin[2];
  scan.ranges.forEach((_, beam) => {
    const z = readingOf(scan, beam, config);
    const reading = scan.range_min <= z && z <= zMax;
    const free = z > zMax && config.no_return === "free";
    if (!reading && !free) return;
    const half = Math.min(Math.abs(scan.angle_increment) / 2, Math.PI / 4);
    const right = heading + bearingOf(scan, beam) - half;
    const [cr, sr, cl, sl] = [Math.cos(right), Math.sin(right), Math.cos(right + 2 * half), Math.sin(right + 2 * half)];
    // Cells farther away get no evidence from this beam.
    const reach = Math.ceil((free ? zMax : Math.min(zMax, z + w / 2)) / resolution);
    const [bottom, top] = [Math.max(0, Math.floor(row0 - reach)), Math.min(rows - 1, Math.ceil(row0 + reach))];
    const [first, last] = [Math.max(0, Math.floor(col0 - reach)), Math.min(cols - 1, Math.ceil(col0 + reach))];
    for (let row = bottom; row <= top; row++) {
      const dRow = row + 0.5 - row0;
      for (let col = first; col <= last; col++) {
        const dCol = col + 0.5 - col0;
        if (cr * dRow - sr * dCol < 0 || cl * dRow - sl * dCol >= 0) continue;
        const r = Math.sqrt(dCol * dCol + dRow * dRow) * resolution;
        const index = row * cols + col;
        if (free) {
          if (r < zMax) updates[index] = config.log_odds_miss;
        } else if (r < z - w / 2) updates[index] = config.log_odds_miss;
        else if (w > 0 && r <= Math.min(zMax, z + w / 2)) updates[index] = config.log_odds_hit;
      }
    }
  });
  scan.ranges.forEach((_, beam) => {
    const z = readingOf(scan, beam, config);
    if (!(scan.range_min <= z && z <= zMax)) return;
    const index = indexOf(geometry, cellOfBeam(geometry, pose, bearingOf(scan, beam), z));
    if (index >= 0) updates[index] = config.log_odds_hit;
  });
  return updates;
}

/** Lattice coordinates (column, row) of the point at distance `z` along a bearing. */
function pointAt(geometry: GridGeometry, pose: Pose, bearing: number, z: number): Point {
  const [px, py] = [z * Math.cos(bearing), z * Math.sin(bearing)];
  const [cos, sin] = [Math.cos(pose[2]), Math.sin(pose[2])];
  return toLattice(geometry, pose[0] + cos * px - sin * py, pose[1] + sin * px + cos * py);
}

const floored = ([u, v]: Point): Cell => ({ row: Math.floor(v), col: Math.floor(u) });

/** The cell that contains the point at distance `z` along a bearing. */
function cellOfBeam(geometry: GridGeometry, pose: Pose, bearing: number, z: number): Cell {
  return floored(pointAt(geometry, pose, bearing, z));
}

/** The distance in metres from the sensor to a cell's centre. */
export function distance(geometry: GridGeometry, pose: Pose, cell: Cell): number {
  const [u, v] = toLattice(geometry, pose[0], pose[1]);
  const [du, dv] = [cell.col + 0.5 - u, cell.row + 0.5 - v];
  return Math.sqrt(du * du + dv * dv) * geometry.resolution;
}
