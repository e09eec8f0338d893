/** One reading of the stage's newest scan, with everything that the pipeline makes of it. */

import { type Cell, cellAt } from "../../grid/lattice";
import { type Evidence, evidenceOfBeam } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import type { Scene, Shown } from "./scene";
import { rangeAt, scanAt } from "./sensing";

export interface Reading {
  readonly pose: Pose;
  /** Metres, and radians in the sensor's frame. */
  readonly range: number;
  readonly bearing: number;
  readonly end: Point;
  readonly cell: Cell;
  /** The evidence of a thin beam for its cells; of a cone none. */
  readonly cells: readonly Evidence[];
}

/** The reading of a beam, with cones of the sonar next to it; null before the first scan, and where it has no return. */
export function readingOf(scene: Scene, shown: Shown, beam: number): Reading | null {
  const at = shown.count - 1;
  const pose = scene.poses[at];
  if (!pose) return null;
  const { conditions, cone, config } = scene;
  const { range, bearing } = rangeAt(pose, at, conditions, cone, beam);
  if (!Number.isFinite(range)) return null;
  const angle = pose[2] + bearing;
  const end: Point = [pose[0] + range * Math.cos(angle), pose[1] + range * Math.sin(angle)];
  const { geometry } = shown.map;
  const cells = cone ? [] : evidenceOfBeam(geometry, scanAt(pose, at, conditions), beam, pose, config);
  return { pose, range, bearing, end, cell: cellAt(geometry, end[0], end[1]), cells };
}
