/**
 * The odometry motion model: where a robot may be after a motion that its odometry tells. Probabilistic Robotics, table
 * 5.6, as mapper/localization/textbook.py, and tested with vectors from there. Metres and radians; random numbers are
 * arguments.
 */

import type { Pose } from "../wire/protocol";
import { compose } from "./lattice";
import { wrapped } from "./poses";

/** α₁ to α₄, and α₅ of the omnidirectional model. */
export type Alphas = readonly [number, number, number, number, ...number[]];
export type OmniAlphas = readonly [number, number, number, number, number];
/** Three draws from the standard normal distribution. */
export type Normals = readonly [number, number, number];
/** Turn, distance and turn: rad, m, rad. */
export type Control = readonly [turn1: number, distance: number, turn2: number];

/** Below this distance, m, the direction of a motion is noise: the first turn is 0 then, as in AMCL. */
const STILL_M = 0.01;

/** Turn, distance and turn between two poses of the odometry. Table 5.6, lines 2 to 4. */
export function odometryControl(before: Pose, after: Pose): Control {
  const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
  const distance = Math.hypot(dx, dy);
  const turn1 = distance < STILL_M ? 0 : wrapped(Math.atan2(dy, dx) - before[2]);
  return [turn1, distance, wrapped(after[2] - before[2] - turn1)];
}

/** Standard deviations of turn, distance and turn. Table 5.6, lines 5 to 7; driving backwards is no half turn. */
export function odometrySigmas([turn1, distance, turn2]: Control, [a1, a2, a3, a4]: Alphas): Control {
  const [r1, r2] = [turn1, turn2].map((r) => Math.min(Math.abs(r), Math.PI - Math.abs(r))) as [number, number];
  const d = distance * distance;
  return [
    Math.sqrt(a1 * r1 * r1 + a2 * d),
    Math.sqrt(a3 * d + a4 * (r1 * r1 + r2 * r2)),
    Math.sqrt(a1 * r2 * r2 + a2 * d),
  ];
}

/** A pose after a motion. Table 5.6, lines 5 to 11. */
export function sampleMotion(control: Control, sigmas: Control, [x, y, yaw]: Pose, normals: Normals): Pose {
  const turn1 = control[0] - sigmas[0] * normals[0];
  const distance = control[1] - sigmas[1] * normals[1];
  const turn2 = control[2] - sigmas[2] * normals[2];
  return [x + distance * Math.cos(yaw + turn1), y + distance * Math.sin(yaw + turn1), wrapped(yaw + turn1 + turn2)];
}

/** A pose after a motion from the origin to `end` by the odometry of a robot that moves sideways too: AMCL's omnidirectional model. */
export function sampleOmni(end: Pose, [a1, a2, a3, a4, a5]: OmniAlphas, normals: Normals): Pose {
  const [distance, turn] = [Math.hypot(end[0], end[1]), end[2]];
  const sideways = Math.sqrt(a4 * turn * turn + a5 * distance * distance) * normals[0];
  const forward = distance - Math.sqrt(a3 * distance * distance + a4 * turn * turn) * normals[1];
  const turned = turn - Math.sqrt(a1 * turn * turn + a2 * distance * distance) * normals[2];
  const [x, y] = compose([0, 0, Math.atan2(end[1], end[0])], [forward, sideways, 0]);
  return [x, y, wrapped(turned)];
}
