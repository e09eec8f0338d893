/** One reading of the stage's newest scan, with everything that the pipeline makes of it. */

import { type Cell, cellAt } from "../../grid/lattice";
import type { LaserScan } from "../../grid/occupancyGrid";
import { bearingOf } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import type { Scene, Shown } from "./scene";
import { scanAt } from "./sensing";

export interface Reading {
  readonly pose: Pose;
  readonly scan: LaserScan;
  readonly beam: number;
  /** Metres, and radians in the sensor's frame. */
  readonly range: number;
  readonly bearing: number;
  readonly end: Point;
  readonly cell: Cell;
}

/** The reading of a beam; null before the first scan, and where it has no return. */
export function readingOf(scene: Scene, shown: Shown, beam: number): Reading | null {
  const at = shown.count - 1;
  const pose = scene.poses[at];
  if (!pose) return null;
  const scan = scanAt(pose, at, scene.conditions);
  const range = scan.ranges[beam] ?? Number.POSITIVE_INFINITY;
  if (!Number.isFinite(range)) return null;
  const bearing = bearingOf(scan, beam);
  const angle = pose[2] + bearing;
  const end: Point = [pose[0] + range * Math.cos(angle), pose[1] + range * Math.sin(angle)];
  return { pose, scan, beam, range, bearing, end, cell: cellAt(shown.map.geometry, end[0], end[1]) };
}
