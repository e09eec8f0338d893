/** The corners of the floor as point landmarks: which were seen, and how often. */

import type { Point, Pose } from "../../wire/protocol";
import { castRay } from "../common/world";
import { TABLE, WALLS } from "./floor";

/** Where two walls meet, or one ends. */
export const CORNERS: readonly Point[] = (() => {
  const found = new Map<string, Point>();
  for (const [x0, y0, x1, y1] of [...WALLS, ...TABLE])
    for (const [x, y] of [
      [x0, y0],
      [x1, y1],
    ] as const)
      found.set(`${x.toFixed(2)} ${y.toFixed(2)}`, [x, y]);
  return [...found.values()];
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
