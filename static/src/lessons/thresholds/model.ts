/**
 * Probabilities to map files, as `mapper/io/maps/writing.py` writes them, and back, as `mapper/io/maps/reading.py`
 * reads them. Tested against files that the mapper wrote (thresholds.vectors.json). Source: nav2_map_server,
 * map_io.cpp, mode trinary.
 */

import { logOdds } from "../../grid/cellValues";
import { emptyGrid, type GridGeometry, INITIAL_CONFIG, type OccupancyGrid } from "../../grid/occupancyGrid";
import { seeded } from "../../grid/random";
import { occupancyGridMapping } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { allRound, box, scanFrom, type Wall } from "../common/world";

export const GREY = { occupied: 0, unknown: 205, free: 254 } as const;
/** Thresholds in the yaml file of a trinary map, whatever thresholds the image was made with. */
export const STATED = { occupied: 0.65, free: 0.196 } as const;

/** The image of a trinary map: greys, top row first. */
export function greysOf(grid: OccupancyGrid, occupied: number, free: number): Uint8Array {
  const { rows, cols } = grid.geometry;
  const [high, low] = [logOdds(occupied), logOdds(free)];
  const out = new Uint8Array(rows * cols).fill(GREY.unknown);
  for (let row = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) {
      const index = row * cols + col;
      if (grid.observed[index] !== 1) continue;
      const value = grid.logOdds[index] ?? 0;
      const image = (rows - 1 - row) * cols + col;
      if (value > high) out[image] = GREY.occupied;
      else if (value < low) out[image] = GREY.free;
    }
  return out;
}

export const pgmHeader = ({ rows, cols }: GridGeometry): string => `P5\n${cols} ${rows}\n255\n`;

const float = (value: number): string => (Number.isInteger(value) ? value.toFixed(1) : String(value));

export function yamlText(geometry: GridGeometry, image: string): string {
  return (
    `image: ${image}\nmode: trinary\nresolution: ${float(geometry.resolution)}\n` +
    `origin: [${geometry.origin.map(float).join(", ")}]\nnegate: 0\n` +
    `occupied_thresh: ${float(STATED.occupied)}\nfree_thresh: ${float(STATED.free)}\n`
  );
}

/** The value that a reader with these thresholds assigns to a grey: 100 occupied, 0 free, −1 unknown. */
export function readValue(grey: number, occupied: number, free: number): 100 | 0 | -1 {
  const occupancy = 1 - grey / 255;
  if (occupancy > occupied) return 100;
  return occupancy < free ? 0 : -1;
}

export interface Counted {
  readonly occupied: number;
  readonly free: number;
  readonly unknown: number;
}

export function counted(greys: Uint8Array, occupied: number, free: number): Counted {
  let [full, empty] = [0, 0];
  for (const grey of greys) {
    const value = readValue(grey, occupied, free);
    if (value === 100) full++;
    else if (value === 0) empty++;
  }
  return { occupied: full, free: empty, unknown: greys.length - full - empty };
}

export const GEOMETRY: GridGeometry = { resolution: 0.1, rows: 28, cols: 42, origin: [-2.1, -1.4, 0] };
const WALLS: readonly Wall[] = [...box(-1.8, -1.1, 1.8, 1.1), [0.3, 1.1, 0.3, 0.1], ...box(-0.9, -0.6, -0.4, -0.2)];

/** A small map of few and noisy scans, in which some cells are certain and others are not. */
export const MAP: OccupancyGrid = (() => {
  const grid = emptyGrid(GEOMETRY);
  const random = seeded(7);
  const lidar = { ...allRound(64, 2.2), noise: { sigma: 0.05, random } };
  const poses: readonly Pose[] = [
    [-1.3, 0.4, 0.1],
    [-1.1, 0.5, 0.4],
    [-0.6, 0.5, 0.9],
    [-0.1, 0.4, 1.4],
    [0.0, -0.4, 2.1],
    [0.9, -0.5, 2.6],
  ];
  for (const pose of poses)
    occupancyGridMapping(grid, scanFrom(WALLS, pose, lidar), pose, { ...INITIAL_CONFIG, range_max: 2.2 });
  return grid;
})();
