/**
 * A wrong sensor mount. The readings are taken with the true mount; the map is made with
 * `T_base_laser ∘ correction`, as the mapper's `mount_*` parameters do it. Source: REP 103, REP 105.
 */

import { compose } from "../../grid/lattice";
import {
  emptyGrid,
  type GridGeometry,
  INITIAL_CONFIG,
  type LaserScan,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import { occupancyGridMapping } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import { box, type Lidar, scanFrom, type Wall } from "../common/world";

export const GEOMETRY: GridGeometry = { resolution: 0.15, rows: 36, cols: 54, origin: [0, 0, 0] };

export const WALLS: readonly Wall[] = [...box(0.6, 0.6, 7.5, 4.8), ...box(2.9, 2.2, 3.7, 3.0), [5.2, 4.8, 5.2, 3.3]];

/** Where the sensor really is on the robot: `T_base_laser`. */
export const TRUE_MOUNT: Pose = [0.25, 0, 0];

/** A laser with a field of view of 270°, so that upside down is not the same as upright. */
export const LIDAR: Lidar = {
  beams: 91,
  angle_min: (-3 * Math.PI) / 4,
  angle_increment: (1.5 * Math.PI) / 90,
  range_min: 0.05,
  range_max: 8,
};

/** Difference between the mount that the map is made with and the true one. */
export interface Correction {
  readonly x: number;
  readonly y: number;
  readonly yaw: number;
  readonly upsideDown: boolean;
}

export const CORRECT: Correction = { x: 0, y: 0, yaw: 0, upsideDown: false };

const heading = (from: Point, to: Point): number => Math.atan2(to[1] - from[1], to[0] - from[0]);

/** The path of the robot around the room: `T_map_base` at each scan. */
export const POSES: readonly Pose[] = (() => {
  const corners: readonly Point[] = [
    [1.5, 1.4],
    [4.3, 1.4],
    [6.6, 1.9],
    [6.4, 2.9],
    [4.4, 3.2],
    [4.2, 4.0],
    [2.0, 4.0],
    [1.5, 2.8],
    [1.5, 1.4],
  ];
  return corners.slice(1).flatMap((to, i) => {
    const from = corners[i] ?? to;
    const yaw = heading(from, to);
    return [0, 0.34, 0.67].map((t): Pose => [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]), yaw]);
  });
})();

const SCANS: readonly LaserScan[] = POSES.map((pose) => scanFrom(WALLS, compose(pose, TRUE_MOUNT), LIDAR));

/** The scan with the bearings of a sensor whose z axis points down. */
const upsideDownScan = (scan: LaserScan): LaserScan => ({
  ...scan,
  angle_min: -scan.angle_min,
  angle_increment: -scan.angle_increment,
});

/** The map of the readings, made with a mount that differs from the true one. */
export function mapWith({ x, y, yaw, upsideDown }: Correction): OccupancyGrid {
  const grid = emptyGrid(GEOMETRY);
  POSES.forEach((pose, i) => {
    const scan = SCANS[i];
    if (!scan) return;
    const sensor = compose(compose(pose, TRUE_MOUNT), [x, y, yaw]);
    occupancyGridMapping(grid, upsideDown ? upsideDownScan(scan) : scan, sensor, INITIAL_CONFIG);
  });
  return grid;
}
