/** The floor of the lecture's stage, and the robot's drive through it. Metres, radians, x forward, y left (REP 103). */

import type { Point, Pose } from "../../wire/protocol";
import { box, castRay, type Wall } from "../common/world";

/** Width and height of the floor, metres. */
export const FLOOR = { width: 12, height: 8 } as const;

/** The part of the south wall that can be polished. */
export const POLISHED: Wall = [3.035, 0.435, 9.035, 0.435];

/** Walls that a laser always sees: a corridor below, two rooms above it, a pillar. */
export const WALLS: readonly Wall[] = [
  [0.435, 0.435, 3.035, 0.435],
  [9.035, 0.435, 11.535, 0.435],
  [11.535, 0.435, 11.535, 7.535],
  [11.535, 7.535, 0.435, 7.535],
  [0.435, 7.535, 0.435, 0.435],
  [0.435, 3.235, 1.835, 3.235],
  [3.135, 3.235, 7.135, 3.235],
  [8.335, 3.235, 11.535, 3.235],
  [5.035, 3.235, 5.035, 7.535],
  ...box(9.535, 1.535, 9.835, 1.835),
];

/** A table that is taken away half way. */
export const TABLE: readonly Wall[] = box(8.735, 4.935, 9.735, 5.635);

/** A low table: a solid block below the plane of the laser, where that is mounted at its usual height. */
export const LOW_TABLE: readonly Wall[] = box(1.335, 5.335, 2.335, 6.135);
/** Height of the low table above the floor, metres. */
export const LOW_TABLE_HEIGHT = 0.35;

const WAYPOINTS: readonly Point[] = [
  [1.2, 1.5],
  [2.5, 1.7],
  [2.5, 4.3],
  [3.7, 6.4],
  [3.2, 4.2],
  [2.5, 3.3],
  [2.8, 1.7],
  [7.6, 1.7],
  [7.7, 4.2],
  [6.1, 6.5],
  [10.5, 6.6],
  [10.5, 4.2],
  [7.8, 4.1],
  [7.7, 1.7],
  [8.6, 1.1],
  [10.8, 1.1],
  [10.8, 2.5],
];

/** Metres between two scans of the drive. */
const STEP = 0.5;

/** The poses of the drive at its scans. */
export const DRIVE: readonly Pose[] = (() => {
  const poses: Pose[] = [];
  let left = 0;
  WAYPOINTS.slice(1).forEach((to, i) => {
    const from = WAYPOINTS[i] ?? to;
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    const yaw = Math.atan2(to[1] - from[1], to[0] - from[0]);
    for (; left < length; left += STEP)
      poses.push([from[0] + left * Math.cos(yaw), from[1] + left * Math.sin(yaw), yaw]);
    left -= length;
  });
  return poses;
})();

/** Scans behind the robot, and the scans between which someone follows it. */
const BEHIND = 2;
const FOLLOWS = { from: 24, to: 33 } as const;

/**
 * Someone who follows the robot along the corridor, at scan `i` of the drive: a circle with a radius of 0.25 m as eight
 * straight sides, or nobody.
 */
export function walker(i: number): readonly Wall[] {
  const pose = i >= FOLLOWS.from && i <= FOLLOWS.to ? DRIVE[i - BEHIND] : undefined;
  if (!pose) return [];
  const corner = (k: number): Point => [
    pose[0] + 0.25 * Math.cos((k * Math.PI) / 4),
    pose[1] + 0.25 * Math.sin((k * Math.PI) / 4),
  ];
  return Array.from({ length: 8 }, (_, k) => [...corner(k), ...corner(k + 1)] as const);
}

/** Where two walls meet, or one ends. */
export const CORNERS: readonly Point[] = (() => {
  const corners = new Map<string, Point>();
  for (const [x0, y0, x1, y1] of [...WALLS, ...TABLE])
    for (const [x, y] of [
      [x0, y0],
      [x1, y1],
    ] as const)
      corners.set(`${x.toFixed(2)} ${y.toFixed(2)}`, [x, y]);
  return [...corners.values()];
})();

/** From farther away a corner is not recognised, metres. */
const REACH = 5;

/** How many of the scans saw each corner. */
export function sightings(poses: readonly Pose[]): readonly number[] {
  return CORNERS.map(
    ([x, y]) =>
      poses.filter((pose) => {
        const d = Math.hypot(x - pose[0], y - pose[1]);
        if (d > REACH) return false;
        return castRay([...WALLS, ...TABLE], pose[0], pose[1], Math.atan2(y - pose[1], x - pose[0])) > d - 0.05;
      }).length,
  );
}
