import type { Point } from "../../../wire/protocol";

/** Whether several poses are all at one place. */
export function standsStill(poses: readonly Point[]): boolean {
  const first = poses[0];
  return first !== undefined && poses.length > 1 && poses.every(([x, y]) => x === first[0] && y === first[1]);
}
