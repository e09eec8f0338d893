/** The odometry motion model: where a robot may be after its wheels have told of a motion. Probabilistic Robotics, table 5.6. */

import { compose } from "./lattice";

export type Pose3 = readonly [x: number, y: number, yaw: number];
export type Alphas = readonly [number, number, number, number, number];
export type Normals = readonly [number, number, number];

const wrap = (angle: number): number => angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));

/** Below this distance, m, the direction of a motion is noise: the first turn is 0 then, as in AMCL. */
const STANDING = 0.01;

/** A pose after a motion from the origin that the odometry takes to end at `end`, with errors by standard `normals`. */
export function sampleDifferential(end: Pose3, alphas: Alphas, normals: Normals): Pose3 {
  const [a1, a2, a3, a4] = alphas;
  const distance = Math.hypot(end[0], end[1]);
  const turn1 = distance < STANDING ? 0 : Math.atan2(end[1], end[0]);
  const turn2 = wrap(end[2] - turn1);
  // Driving backwards is no half turn.
  const r1 = Math.min(Math.abs(turn1), Math.PI - Math.abs(turn1));
  const r2 = Math.min(Math.abs(turn2), Math.PI - Math.abs(turn2));
  const t1 = turn1 - Math.sqrt(a1 * r1 * r1 + a2 * distance * distance) * normals[0];
  const d = distance - Math.sqrt(a3 * distance * distance + a4 * (r1 * r1 + r2 * r2)) * normals[1];
  const t2 = turn2 - Math.sqrt(a1 * r2 * r2 + a2 * distance * distance) * normals[2];
  return [d * Math.cos(t1), d * Math.sin(t1), wrap(t1 + t2)];
}

/** The same of a robot that moves sideways too: AMCL's omnidirectional model. */
export function sampleOmni(end: Pose3, alphas: Alphas, normals: Normals): Pose3 {
  const [a1, a2, a3, a4, a5] = alphas;
  const [distance, turn] = [Math.hypot(end[0], end[1]), end[2]];
  const sideways = Math.sqrt(a4 * turn * turn + a5 * distance * distance) * normals[0];
  const forward = distance - Math.sqrt(a3 * distance * distance + a4 * turn * turn) * normals[1];
  const turned = turn - Math.sqrt(a1 * turn * turn + a2 * distance * distance) * normals[2];
  const [x, y] = compose([0, 0, Math.atan2(end[1], end[0])], [forward, sideways, 0]);
  return [x, y, wrap(turned)];
}
