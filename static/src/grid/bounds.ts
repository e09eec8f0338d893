/** Axis-aligned boxes in the world. */

/** A box in world metres: x0, y0, x1, y1. */
export type Bounds = readonly [x0: number, y0: number, x1: number, y1: number];

/** The smallest box around two. */
export const around = (a: Bounds, b: Bounds): Bounds => [
  Math.min(a[0], b[0]),
  Math.min(a[1], b[1]),
  Math.max(a[2], b[2]),
  Math.max(a[3], b[3]),
];
