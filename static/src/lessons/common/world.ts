/** A world of straight walls, and a lidar in it. Metres, radians, x forward, y left (REP 103). */

import { compose } from "../../grid/lattice";
import type { LaserScan } from "../../grid/occupancyGrid";
import { normal } from "../../grid/random";
import type { Point, Pose } from "../../wire/protocol";

export type Wall = readonly [x0: number, y0: number, x1: number, y1: number];

/** The four walls of a box. */
export const box = (x0: number, y0: number, x1: number, y1: number): readonly Wall[] => [
  [x0, y0, x1, y0],
  [x1, y0, x1, y1],
  [x1, y1, x0, y1],
  [x0, y1, x0, y0],
];

/** Distance from a point to the nearest of some walls. */
export function distanceTo([x, y]: Point, walls: readonly Wall[]): number {
  let best = Number.POSITIVE_INFINITY;
  for (const [x0, y0, x1, y1] of walls) {
    const [wx, wy] = [x1 - x0, y1 - y0];
    const t = Math.min(1, Math.max(0, ((x - x0) * wx + (y - y0) * wy) / (wx * wx + wy * wy || 1)));
    best = Math.min(best, Math.hypot(x - x0 - t * wx, y - y0 - t * wy));
  }
  return best;
}

/** Metres from a point along a direction to the nearest wall, Infinity where there is none. */
export function castRay(walls: readonly Wall[], x: number, y: number, angle: number): number {
  const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
  let nearest = Number.POSITIVE_INFINITY;
  for (const [x0, y0, x1, y1] of walls) {
    const [wx, wy] = [x1 - x0, y1 - y0];
    const across = dx * wy - dy * wx;
    if (Math.abs(across) < 1e-12) continue;
    const t = ((x0 - x) * wy - (y0 - y) * wx) / across;
    const along = ((x0 - x) * dy - (y0 - y) * dx) / across;
    if (t > 0 && t < nearest && along >= 0 && along <= 1) nearest = t;
  }
  return nearest;
}

export interface Lidar {
  readonly beams: number;
  readonly angle_min: number;
  readonly angle_increment: number;
  readonly range_min: number;
  readonly range_max: number;
  /** Standard deviation of a reading, metres, and where its random numbers come from. */
  readonly noise?: { readonly sigma: number; readonly random: () => number };
}

/** A lidar with a field of view of 360°, its first beam straight ahead. */
export const allRound = (beams: number, range_max: number): Lidar => ({
  beams,
  angle_min: 0,
  angle_increment: (2 * Math.PI) / beams,
  range_min: 0.05,
  range_max,
});

/** One scan from a sensor at `pose`; walls beyond the lidar's range give no return. */
export function scanFrom(walls: readonly Wall[], [x, y, yaw]: Pose, lidar: Lidar): LaserScan {
  const ranges = new Float32Array(lidar.beams);
  for (let beam = 0; beam < lidar.beams; beam++) {
    const exact = castRay(walls, x, y, yaw + lidar.angle_min + beam * lidar.angle_increment);
    const z = lidar.noise ? exact + lidar.noise.sigma * normal(lidar.noise.random) : exact;
    ranges[beam] = z <= lidar.range_max ? z : Number.POSITIVE_INFINITY;
  }
  const { angle_min, angle_increment, range_min, range_max } = lidar;
  return { ranges, angle_min, angle_increment, range_min, range_max };
}

/** The poses from the first one on, each moved from the one before. */
export function chained(first: Pose, motions: readonly Pose[]): readonly Pose[] {
  const poses = [first];
  let last = first;
  for (const motion of motions) {
    last = compose(last, motion);
    poses.push(last);
  }
  return poses;
}
