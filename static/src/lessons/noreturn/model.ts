/** Beams without a return, interpreted in three ways: ignored, as free space, and, wrongly, as a hit at max range. */

import {
  emptyGrid,
  type GridGeometry,
  INITIAL_CONFIG,
  type LaserScan,
  type MappingConfig,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import { occupancyGridMapping } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import { allRound, box, castRay, scanFrom, type Wall } from "../common/world";

export const GEOMETRY: GridGeometry = { resolution: 0.2, rows: 32, cols: 48, origin: [0, 0, 0] };

/** A hall with a pillar, and a pane of glass from which no beam returns. */
export const WALLS: readonly Wall[] = [...box(0.5, 0.5, 9.1, 5.9), ...box(6.3, 3.9, 6.9, 4.5)];
export const GLASS: readonly Wall[] = [[3.9, 0.5, 3.9, 2.1]];

export const POLICIES = ["ignore", "free", "hit"] as const;
export type Policy = (typeof POLICIES)[number];

/** Where the robot stands at first. */
export const FIRST_PLACE: Point = [2.4, 2.5];

const BEAMS = 180;
const SCANS = 4;

/** One scan: no return where the nearest surface is glass or lies beyond the max range. */
export function scanAt([x, y]: Point, rangeMax: number): LaserScan {
  const scan = scanFrom(WALLS, [x, y, 0], allRound(BEAMS, rangeMax));
  const ranges = scan.ranges.map((z, beam) => {
    const glass = castRay(GLASS, x, y, scan.angle_min + beam * scan.angle_increment);
    return glass < z ? Number.POSITIVE_INFINITY : z;
  });
  return { ...scan, ranges };
}

/** How many beams of a scan have no return. */
export const withoutReturn = (point: Point, rangeMax: number): number =>
  scanAt(point, rangeMax).ranges.filter((range) => !Number.isFinite(range)).length;

/** The map of a few scans from one place, under a policy. */
export function mapAt(point: Point, rangeMax: number, policy: Policy): OccupancyGrid {
  const grid = emptyGrid(GEOMETRY);
  const pose: Pose = [point[0], point[1], 0];
  const scan = scanAt(point, rangeMax);
  const config: MappingConfig = { ...INITIAL_CONFIG, range_max: rangeMax, no_return: policy };
  for (let i = 0; i < SCANS; i++) occupancyGridMapping(grid, scan, pose, config);
  return grid;
}
