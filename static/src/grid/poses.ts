import type { Pose } from "../wire/protocol";

/** An angle in −π … π, radians. */
export const wrapped = (angle: number): number => angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));

/** T_a_b of T_o_a and T_o_b: the motion from the one to the other, or the pose of b in the frame of a. */
export function between(a: Pose, b: Pose): Pose {
  const [c, s] = [Math.cos(a[2]), Math.sin(a[2])];
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  return [c * dx + s * dy, -s * dx + c * dy, wrapped(b[2] - a[2])];
}
