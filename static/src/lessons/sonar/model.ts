/**
 * Wide beams: the sonar cone of the Bayes filter, and the two certainties of Moravec and Elfes. TypeScript versions of
 * `evidence_in_cone` and `update_moravec_elfes` in mapper/mapping/textbook.py, tested on the same vectors
 * (sonar.vectors.json). Source: Moravec & Elfes 1985; Elfes 1989; Probabilistic Robotics, table 9.2.
 */

import { logOdds } from "../../grid/cellValues";
import { toLattice } from "../../grid/lattice";
import {
  type GridGeometry,
  INITIAL_CONFIG,
  type MappingConfig,
  type OccupancyGrid,
  statisticsOf,
} from "../../grid/occupancyGrid";
import { halfWindow, INITIAL_PARAMETERS, increment, type SensorModelParameters } from "../../grid/sensorModel";
import { bayesFilter } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";

export interface SonarScan {
  readonly ranges: Float32Array;
  /** Radians in the sensor's frame. */
  readonly bearings: readonly number[];
  readonly range_min: number;
  readonly range_max: number;
}

export interface SonarSettings {
  /** The cone from edge to edge, radians. */
  readonly opening: number;
  /** r, metres; at least the side of a cell. */
  readonly window: number;
  readonly profile: "flat" | "gaussian";
  readonly no_return: "ignore" | "free";
}

interface ConeCell {
  readonly index: number;
  /** Distance of the cell's centre from the sensor, metres, and its angle from the cone's axis. */
  readonly s: number;
  readonly theta: number;
}

const f32 = Math.fround;

/** The cells whose centre lies in a cone, the right edge included: at least all that are within `reach` metres. */
function cellsInCone(
  geometry: GridGeometry,
  pose: Pose,
  bearing: number,
  opening: number,
  reach: number,
): readonly ConeCell[] {
  const [col0, row0] = toLattice(geometry, pose[0], pose[1]);
  const within = reach / geometry.resolution;
  const [bottom, top] = [Math.max(0, Math.floor(row0 - within)), Math.min(geometry.rows - 1, Math.ceil(row0 + within))];
  const [first, last] = [Math.max(0, Math.floor(col0 - within)), Math.min(geometry.cols - 1, Math.ceil(col0 + within))];
  const heading = pose[2] - geometry.origin[2] + bearing;
  const half = opening / 2;
  const [cr, sr] = [Math.cos(heading - half), Math.sin(heading - half)];
  const [cl, sl] = [Math.cos(heading + half), Math.sin(heading + half)];
  const [ca, sa] = [Math.cos(heading), Math.sin(heading)];
  const cells: ConeCell[] = [];
  for (let row = bottom; row <= top; row++) {
    const dRow = row + 0.5 - row0;
    for (let col = first; col <= last; col++) {
      const dCol = col + 0.5 - col0;
      if (cr * dRow - sr * dCol < 0 || cl * dRow - sl * dCol >= 0) continue;
      const theta = Math.atan2(ca * dRow - sa * dCol, ca * dCol + sa * dRow);
      cells.push({
        index: row * geometry.cols + col,
        s: Math.sqrt(dCol * dCol + dRow * dRow) * geometry.resolution,
        theta: Math.min(half, Math.max(-half, theta)),
      });
    }
  }
  return cells;
}

/** The settings as parameters of the sensor model, which computes the evidence. */
export const coneModel = (
  model: "sonar_cone" | "moravec_elfes",
  settings: SonarSettings,
  range_max: number,
): SensorModelParameters => ({
  ...INITIAL_PARAMETERS,
  model,
  opening: settings.opening,
  window: settings.window,
  cone_profile: settings.profile,
  no_return: settings.no_return,
  range_max,
});

/** Limits of the log-odds. */
type Limits = Pick<MappingConfig, "clamp" | "log_odds_min" | "log_odds_max">;

/** The model for a scan, whose range limits it, on a grid, whose cell is the least window. */
const modelFor = (values: SensorModelParameters, scan: SonarScan, { geometry }: OccupancyGrid) => ({
  ...values,
  range_max: scan.range_max,
  resolution: geometry.resolution,
});

const isReading = (scan: SonarScan, z: number): boolean => scan.range_min <= z && z <= scan.range_max;
const isFree = (scan: SonarScan, z: number, { no_return }: SensorModelParameters): boolean =>
  z > scan.range_max && no_return === "free";

/** Add a scan to a map by the method of the model. */
export function updateWide(
  grid: OccupancyGrid,
  scan: SonarScan,
  pose: Pose,
  model: SensorModelParameters,
  config: Limits = INITIAL_CONFIG,
): void {
  const values = modelFor(model, scan, grid);
  if (values.model === "moravec_elfes") updateMoravecElfes(grid, scan, pose, values, config);
  else updateCone(grid, scan, pose, values, config);
}

/** Bayes filter: every cell of the cone up to z + w/2 gets its evidence, reading by reading. */
function updateCone(
  grid: OccupancyGrid,
  scan: SonarScan,
  pose: Pose,
  values: SensorModelParameters,
  config: Limits,
): void {
  scan.ranges.forEach((z, k) => {
    const half = halfWindow(z, values);
    const reading = isReading(scan, z);
    const free = isFree(scan, z, values);
    if (!reading && !free) return;
    const reach = reading ? Math.min(z + half, scan.range_max) : scan.range_max;
    const cells = cellsInCone(grid.geometry, pose, scan.bearings[k] ?? 0, values.opening, reach);
    for (const { index, s, theta } of cells) {
      if (reading ? s > reach : s >= reach) continue;
      grid.logOdds[index] = bayesFilter(grid.logOdds[index] ?? 0, increment(s, z, values, theta), config);
      grid.observed[index] = 1;
    }
  });
}

/**
 * The two certainties of Moravec and Elfes (1985), which the grid keeps: first the empty ones of all readings; then the
 * occupied ones, cancelled and normalised, reading by reading.
 */
function updateMoravecElfes(
  grid: OccupancyGrid,
  scan: SonarScan,
  pose: Pose,
  values: SensorModelParameters,
  config: Limits,
): void {
  const [occupied, empty] = statisticsOf(grid);
  const cones = Array.from(scan.ranges, (z, k) => ({
    z,
    cells: cellsInCone(
      grid.geometry,
      pose,
      scan.bearings[k] ?? 0,
      values.opening,
      isReading(scan, z) ? z + halfWindow(z, values) : scan.range_max,
    ),
  }));
  for (const { z, cells } of cones) {
    if (!isReading(scan, z) && !isFree(scan, z, values)) continue;
    const end = isReading(scan, z) ? z - halfWindow(z, values) : scan.range_max;
    for (const { index, s, theta } of cells) {
      if (s >= end) continue;
      const certainty = -increment(s, z, values, theta);
      const before = empty[index] ?? 0;
      empty[index] = f32(before + certainty * (1 - before));
      grid.observed[index] = 1;
    }
  }
  for (const { z, cells } of cones) {
    if (!isReading(scan, z)) continue;
    const half = halfWindow(z, values);
    const arc = cells
      .filter(({ s }) => s >= z - half && s <= Math.min(z + half, scan.range_max))
      .map(({ index, s, theta }) => ({
        index,
        share: increment(s, z, values, theta) * (1 - (empty[index] ?? 0)),
      }));
    const total = arc.reduce((sum, { share }) => sum + share, 0);
    if (total <= 0) continue;
    for (const { index, share } of arc) {
      const before = occupied[index] ?? 0;
      occupied[index] = f32(before + (share / total) * (1 - before));
      grid.observed[index] = 1;
    }
  }
  show(grid, config);
}

/** Log-odds for display: ℓ of p = (1 + v)/2, where v is the greater of the two certainties, negative for empty. */
function show(grid: OccupancyGrid, config: Limits): void {
  const [occupied, empty] = statisticsOf(grid);
  grid.observed.forEach((seen, index) => {
    if (seen !== 1) return;
    const [occ, emp] = [occupied[index] ?? 0, empty[index] ?? 0];
    const value = occ >= emp ? occ : -emp;
    grid.logOdds[index] = bayesFilter(0, logOdds((1 + value) / 2), config);
  });
}
