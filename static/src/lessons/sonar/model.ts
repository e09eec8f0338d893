/**
 * Wide beams: the sonar cone of the Bayes filter, and the two certainties of Moravec and Elfes. TypeScript versions of
 * `evidence_in_cone` and `update_moravec_elfes` in mapper/mapping/textbook.py, tested on the same vectors
 * (sonar.vectors.json). Source: Moravec & Elfes 1985; Elfes 1989; Probabilistic Robotics, table 9.2.
 */

import { toLattice } from "../../grid/lattice";
import { logOdds } from "../../grid/logOdds";
import { emptyGrid, type GridGeometry, INITIAL_CONFIG, type OccupancyGrid } from "../../grid/occupancyGrid";
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

/** The cells whose centre lies in a cone, the right edge included. */
function cellsInCone(geometry: GridGeometry, pose: Pose, bearing: number, opening: number): readonly ConeCell[] {
  const [col0, row0] = toLattice(geometry, pose[0], pose[1]);
  const heading = pose[2] - geometry.origin[2] + bearing;
  const half = opening / 2;
  const [cr, sr] = [Math.cos(heading - half), Math.sin(heading - half)];
  const [cl, sl] = [Math.cos(heading + half), Math.sin(heading + half)];
  const [ca, sa] = [Math.cos(heading), Math.sin(heading)];
  const cells: ConeCell[] = [];
  for (let row = 0; row < geometry.rows; row++) {
    const dRow = row + 0.5 - row0;
    for (let col = 0; col < geometry.cols; col++) {
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

/** The settings as parameters of the sensor model of section 4, which computes the evidence. */
const asProfile = (
  model: "sonar_cone" | "moravec_elfes",
  settings: SonarSettings,
  scan: SonarScan,
  geometry: GridGeometry,
): SensorModelParameters => ({
  ...INITIAL_PARAMETERS,
  model,
  opening: settings.opening,
  window: settings.window,
  cone_profile: settings.profile,
  no_return: settings.no_return,
  range_max: scan.range_max,
  resolution: geometry.resolution,
});

const isReading = (scan: SonarScan, z: number): boolean => scan.range_min <= z && z <= scan.range_max;
const isFree = (scan: SonarScan, z: number, settings: SonarSettings): boolean =>
  z > scan.range_max && settings.no_return === "free";

/** Bayes filter: every cell of the cone up to z + w/2 gets its evidence, reading by reading. */
export function updateCone(grid: OccupancyGrid, scan: SonarScan, pose: Pose, settings: SonarSettings): void {
  const values = asProfile("sonar_cone", settings, scan, grid.geometry);
  scan.ranges.forEach((z, k) => {
    const half = halfWindow(z, values);
    const reading = isReading(scan, z);
    const free = isFree(scan, z, settings);
    if (!reading && !free) return;
    for (const { index, s, theta } of cellsInCone(grid.geometry, pose, scan.bearings[k] ?? 0, settings.opening)) {
      if (reading ? s > Math.min(z + half, scan.range_max) : s >= scan.range_max) continue;
      grid.logOdds[index] = bayesFilter(grid.logOdds[index] ?? 0, increment(s, z, values, theta), INITIAL_CONFIG);
      grid.observed[index] = 1;
    }
  });
}

/** The two grids of Moravec and Elfes (1985): certainty that a cell is occupied, and certainty that it is empty. */
export interface Certainties {
  readonly grid: OccupancyGrid;
  readonly occupied: Float32Array;
  readonly empty: Float32Array;
}

export function noCertainties(geometry: GridGeometry): Certainties {
  const grid = emptyGrid(geometry);
  const count = grid.logOdds.length;
  return { grid, occupied: new Float32Array(count), empty: new Float32Array(count) };
}

/**
 * First the empty certainties of all readings; then the occupied ones, cancelled and normalised, reading by reading.
 */
export function updateMoravecElfes(map: Certainties, scan: SonarScan, pose: Pose, settings: SonarSettings): void {
  const { grid, occupied, empty } = map;
  const values = asProfile("moravec_elfes", settings, scan, grid.geometry);
  const cones = Array.from(scan.ranges, (z, k) => ({
    z,
    cells: cellsInCone(grid.geometry, pose, scan.bearings[k] ?? 0, settings.opening),
  }));
  for (const { z, cells } of cones) {
    if (!isReading(scan, z) && !isFree(scan, z, settings)) continue;
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
  show(map);
}

/** Log-odds for display: ℓ of p = (1 + v)/2, where v is the greater of the two certainties, negative for empty. */
function show({ grid, occupied, empty }: Certainties): void {
  grid.observed.forEach((seen, index) => {
    if (seen !== 1) return;
    const [occ, emp] = [occupied[index] ?? 0, empty[index] ?? 0];
    const value = occ >= emp ? occ : -emp;
    const shown = logOdds((1 + value) / 2);
    grid.logOdds[index] = Math.min(INITIAL_CONFIG.log_odds_max, Math.max(INITIAL_CONFIG.log_odds_min, shown));
  });
}
