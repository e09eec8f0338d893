/** Where the robot of the stage is, and how a reader moves it. */

import type { Point, Pose } from "../../wire/protocol";
import { ownPoses, ownRobot } from "./controls";
import { POLISHED, TABLE, WALLS } from "./floor";
import type { Scene, Shown } from "./scene";

/** The reader adds a scan after this way, metres. */
const WAY = 0.25;
const MOST_SCANS = 150;
/** The robot's centre keeps this far from walls, metres. */
const RADIUS = 0.2;

export const robotOf = (scene: Scene, shown: Shown): Pose | null =>
  ownRobot.value ?? scene.poses[Math.max(0, Math.min(shown.count, scene.poses.length) - 1)] ?? null;

function isFree([x, y]: Point): boolean {
  return [...WALLS, POLISHED, ...TABLE].every(([x0, y0, x1, y1]) => {
    const [wx, wy] = [x1 - x0, y1 - y0];
    const t = Math.min(1, Math.max(0, ((x - x0) * wx + (y - y0) * wy) / (wx * wx + wy * wy)));
    return Math.hypot(x - x0 - t * wx, y - y0 - t * wy) >= RADIUS;
  });
}

const isInside = ([x, y]: Point): boolean => x > 0.6 && x < 11.4 && y > 0.6 && y < 7.4;

/** Move the robot to a point, if it is free, and add scans on the way. */
export function moveRobot(point: Point, from: Pose): void {
  if (!isInside(point) || !isFree(point)) return;
  const way = Math.hypot(point[0] - from[0], point[1] - from[1]);
  const yaw = way > 0.02 ? Math.atan2(point[1] - from[1], point[0] - from[0]) : from[2];
  const pose: Pose = [point[0], point[1], yaw];
  ownRobot.value = pose;
  const last = ownPoses.peek().at(-1);
  const isFar = !last || Math.hypot(point[0] - last[0], point[1] - last[1]) >= WAY - 1e-9;
  if (isFar && ownPoses.peek().length < MOST_SCANS) ownPoses.value = [...ownPoses.peek(), pose];
}
