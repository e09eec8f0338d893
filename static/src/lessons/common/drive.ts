/** Drives along closed ways, and how far estimated poses are from the true ones. Metres, radians. */

import type { Point, Pose } from "../../wire/protocol";

/** The pose after `way` metres along a closed polygon, facing along its side. */
export function poseRound(corners: readonly Point[], way: number): Pose {
  let left = way;
  for (let k = 0; ; k++) {
    const [ax, ay] = corners[k % corners.length] as Point;
    const [bx, by] = corners[(k + 1) % corners.length] as Point;
    const length = Math.hypot(bx - ax, by - ay);
    if (left < length) {
      const share = left / length;
      return [ax + share * (bx - ax), ay + share * (by - ay), Math.atan2(by - ay, bx - ax)];
    }
    left -= length;
  }
}

/** The root of the mean square of the distances of poses from the true ones. */
export const rmsDistance = (poses: readonly Pose[], truth: readonly Pose[]): number =>
  Math.sqrt(
    poses.reduce((sum, [x, y], k) => sum + (x - (truth[k]?.[0] ?? 0)) ** 2 + (y - (truth[k]?.[1] ?? 0)) ** 2, 0) /
      poses.length,
  );
