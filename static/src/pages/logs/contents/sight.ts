/** Where a camera sees a place of the map's floor. */

import type { Point } from "../../../wire/protocol";

export interface Sight {
  readonly where: "inside" | "outside" | "behind";
  /** Shares of the image's width and height, from its upper left corner; of a place behind the camera 0. */
  readonly u: number;
  readonly v: number;
}

/**
 * Where a place, metres in the map, is in an image. `projection` (3, 4), row after row, takes (x, y, z, 1) to
 * (u w, v w, w), w being the depth in metres; the place is on the floor, z = 0.
 */
export function sightOf(projection: readonly number[], [x, y]: Point): Sight {
  const along = (row: number): number => {
    const [a = 0, b = 0, , d = 0] = projection.slice(4 * row, 4 * row + 4);
    return a * x + b * y + d;
  };
  const depth = along(2);
  if (depth <= 0) return { where: "behind", u: 0, v: 0 };
  const [u, v] = [along(0) / depth, along(1) / depth];
  return { where: Math.min(u, v) >= 0 && Math.max(u, v) <= 1 ? "inside" : "outside", u, v };
}
