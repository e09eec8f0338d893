/** The room in which the sonars of section 7 measure. */

import type { GridGeometry } from "../../grid/occupancyGrid";
import type { Point, Pose } from "../../wire/protocol";
import { box, castRay, type Wall } from "../common/world";
import type { SonarScan } from "./model";

export const GEOMETRY: GridGeometry = { resolution: 0.1, rows: 34, cols: 50, origin: [0, 0, 0] };

/** A room with a door on the right, a gap as wide as a robot, and a post. */
export const WALLS: readonly Wall[] = [
  [0.4, 0.4, 4.6, 0.4],
  [0.4, 0.4, 0.4, 3.0],
  [0.4, 3.0, 4.6, 3.0],
  [4.6, 0.4, 4.6, 1.3],
  [4.6, 2.1, 4.6, 3.0],
  ...box(2.4, 2.2, 2.7, 2.5),
];

export const SONARS = 16;
export const RANGE_MAX = 3;
/** Number of rays cast in a cone to find its nearest surface. */
const RAYS = 25;

/** The path of the robot: one scan of all sonars at each pose. */
export const POSES: readonly Pose[] = (
  [
    [0.95, 0.95],
    [1.25, 1.05],
    [1.55, 1.2],
    [1.85, 1.3],
    [2.2, 1.4],
    [2.6, 1.45],
    [3.0, 1.55],
    [3.4, 1.65],
    [3.75, 1.7],
  ] as readonly Point[]
).map(([x, y]): Pose => [x, y, 0.24]);

/** One scan of a ring of sonars: the nearest surface in each cone, no return if there is none within range. */
export function sonarScan(
  pose: Pose,
  opening: number,
  walls: readonly Wall[] = WALLS,
  rangeMax: number = RANGE_MAX,
): SonarScan {
  const bearings = Array.from({ length: SONARS }, (_, k) => (k * 2 * Math.PI) / SONARS);
  const ranges = Float32Array.from(bearings, (bearing) => {
    const echoes = Array.from({ length: RAYS }, (_, i) =>
      castRay(walls, pose[0], pose[1], pose[2] + bearing + opening * (i / (RAYS - 1) - 0.5)),
    );
    const z = Math.min(...echoes);
    return z <= rangeMax ? z : Number.POSITIVE_INFINITY;
  });
  return { ranges, bearings, range_min: 0.05, range_max: rangeMax };
}
