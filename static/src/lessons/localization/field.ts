/** The likelihood field of the floor, and how well a scan fits a pose in it. Metres, radians. */

import type { GridGeometry } from "../../grid/occupancyGrid";
import { normal, seeded } from "../../grid/random";
import { type FieldMixture, fieldLikelihood } from "../../grid/rangeModels";
import type { Point, Pose } from "../../wire/protocol";
import { allRound, distanceTo, scanFrom, type Wall } from "../common/world";
import { FLOOR, POLISHED, TABLE, WALLS } from "../stage/floor";
import { geometryOf } from "../stage/sensing";

/** What the map has: all walls and the cupboard. */
export const MAPPED: readonly Wall[] = [...WALLS, POLISHED, ...TABLE];
export const FIELD_GEOMETRY: GridGeometry = geometryOf(0.1, FLOOR.width, FLOOR.height);
/** Farther end points count as if they were so far: laser_likelihood_max_dist. */
const FARTHEST = 2;
export const RANGE_MAX = 8;
export const BEAMS = 36;
const NOISE = 0.02;
/** AMCL's first values. */
export const MIXTURE: FieldMixture = { z_hit: 0.5, z_rand: 0.5, sigma_hit: 0.2, range_max: RANGE_MAX };

let cached: Float32Array | null = null;

/** Distance of each cell's centre from the nearest wall of the map, at most {@link FARTHEST}; row 0 at the smallest y. */
export function distances(): Float32Array {
  if (cached) return cached;
  const { rows, cols, resolution } = FIELD_GEOMETRY;
  cached = Float32Array.from({ length: rows * cols }, (_, i) => {
    const centre: Point = [((i % cols) + 0.5) * resolution, (Math.floor(i / cols) + 0.5) * resolution];
    return Math.min(FARTHEST, distanceTo(centre, MAPPED));
  });
  return cached;
}

/** Distance of a point from the nearest wall by the field. */
export function distanceAt(x: number, y: number): number {
  const { rows, cols, resolution } = FIELD_GEOMETRY;
  const [row, col] = [Math.floor(y / resolution), Math.floor(x / resolution)];
  if (row < 0 || col < 0 || row >= rows || col >= cols) return FARTHEST;
  return distances()[row * cols + col] ?? FARTHEST;
}

/** Whether a robot can stand at a point: on the floor, and not in a wall. */
export const isFree = ([x, y]: Point, margin = 0.2): boolean =>
  x > 0.5 && x < 11.5 && y > 0.5 && y < 7.5 && distanceAt(x, y) >= margin;

/** End points of a scan in the frame of the robot; beams without a return are left out. */
export function endPoints(pose: Pose, seed: number): readonly Point[] {
  const noise = { sigma: NOISE, random: seeded(seed) };
  const scan = scanFrom(MAPPED, pose, { ...allRound(BEAMS, RANGE_MAX), noise });
  return [...scan.ranges].flatMap((range, k): Point[] => {
    const bearing = scan.angle_min + k * scan.angle_increment;
    return Number.isFinite(range) ? [[range * Math.cos(bearing), range * Math.sin(bearing)]] : [];
  });
}

/** log p(z | x, m) of end points seen from a pose, in nats: the sum of the logarithms of table 6.3. */
export function logLikelihood(points: readonly Point[], [x, y, yaw]: Pose, mixture: FieldMixture = MIXTURE): number {
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  let sum = 0;
  for (const [px, py] of points)
    sum += Math.log(fieldLikelihood(distanceAt(x + c * px - s * py, y + s * px + c * py), mixture));
  return sum;
}

/** A pose anywhere on the free floor. */
export function randomPose(random: () => number): Pose {
  for (;;) {
    const point: Point = [random() * FLOOR.width, random() * FLOOR.height];
    if (isFree(point)) return [point[0], point[1], (2 * random() - 1) * Math.PI];
  }
}

/** Three draws from the standard normal distribution. */
export const threeNormals = (random: () => number): readonly [number, number, number] => [
  normal(random),
  normal(random),
  normal(random),
];
