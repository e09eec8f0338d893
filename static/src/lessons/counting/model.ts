/** How often one scan updates a cell: per beam and per scan. */

import type { Cell } from "../../grid/lattice";
import {
  emptyGrid,
  type GridGeometry,
  INITIAL_CONFIG,
  indexOf,
  type MappingConfig,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import { distance, evidenceOfBeam, occupancyGridMapping } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { allRound, box, scanFrom, type Wall } from "../common/world";

export const GEOMETRY: GridGeometry = { resolution: 0.1, rows: 26, cols: 38, origin: [0, 0, 0] };
export const WALLS: readonly Wall[] = [...box(0.25, 0.25, 3.55, 2.35), ...box(2.35, 1.65, 2.75, 2.05)];
export const SENSOR: Pose = [1.14, 1.17, 0];

const scanOf = (beams: number) => scanFrom(WALLS, SENSOR, allRound(beams, 8));

/** The map after a few scans from the same place. */
export function mapWith(update: MappingConfig["update"], beams: number, scans: number): OccupancyGrid {
  const grid = emptyGrid(GEOMETRY);
  const scan = scanOf(beams);
  for (let i = 0; i < scans; i++) occupancyGridMapping(grid, scan, SENSOR, { ...INITIAL_CONFIG, update });
  return grid;
}

/** How many beams of one scan update each cell. */
export function beamsPerCell(beams: number): Uint16Array {
  const counts = new Uint16Array(GEOMETRY.rows * GEOMETRY.cols);
  const scan = scanOf(beams);
  for (let beam = 0; beam < beams; beam++)
    for (const { cell } of evidenceOfBeam(GEOMETRY, scan, beam, SENSOR, INITIAL_CONFIG)) {
      const index = indexOf(GEOMETRY, cell);
      if (index >= 0) counts[index] = (counts[index] ?? 0) + 1;
    }
  return counts;
}

/** Expected number of beams through a cell at distance `s` metres: those whose bearing its width covers. */
export const expectedBeams = (s: number, beams: number): number => (beams * GEOMETRY.resolution) / (2 * Math.PI * s);

export const distanceOf = (cell: Cell): number => distance(GEOMETRY, SENSOR, cell);
