/** The arithmetic of the overview beside a zoomed map. */

import type { Bounds } from "../../grid/lattice";
import { fitted, type Size, toScreen, type View } from "../../render/view";
import type { Point } from "../../wire/protocol";

/** The largest overview, and the smallest picture that has room for one, CSS px. */
const LARGEST: Size = { width: 168, height: 126 };
const LEAST_PICTURE: Size = { width: 560, height: 360 };
/** A map that is as long as a corridor still has so high an overview, CSS px. */
const LEAST_SIDE = 28;

/** The corners of what a picture shows of the world. */
function visible(view: View, { width, height }: Size): Bounds {
  const [wide, high] = [(width / 2) * view.scale, (height / 2) * view.scale];
  return [view.x - wide, view.y - high, view.x + wide, view.y + high];
}

export interface OverviewBox {
  readonly size: Size;
  /** The view of the whole map in the overview. */
  readonly whole: View;
  /** Left, top, width and height of what the picture shows, CSS px in the overview. */
  readonly shown: readonly [left: number, top: number, width: number, height: number];
}

/** Where the overview has what; null where the picture shows all of `bounds`, or has no room. */
export function overviewBox(bounds: Bounds, view: View, picture: Size): OverviewBox | null {
  if (picture.width < LEAST_PICTURE.width || picture.height < LEAST_PICTURE.height) return null;
  const [x0, y0, x1, y1] = bounds;
  const [left, bottom, right, top] = visible(view, picture);
  if (left <= x0 && bottom <= y0 && right >= x1 && top >= y1) return null;
  const scale = Math.max((x1 - x0) / LARGEST.width, (y1 - y0) / LARGEST.height);
  if (!(scale > 0)) return null;
  const size = {
    width: Math.max(LEAST_SIDE, Math.round((x1 - x0) / scale)),
    height: Math.max(LEAST_SIDE, Math.round((y1 - y0) / scale)),
  };
  const whole = fitted(bounds, size, 0);
  const [px, py] = toScreen(whole, size, left, top);
  const shown = [px, py, (right - left) / whole.scale, (top - bottom) / whole.scale] as const;
  return { size, whole, shown };
}

/** The view centred at a place, or at the nearest one of the map. */
export function centredAt(view: View, [x0, y0, x1, y1]: Bounds, [x, y]: Point): View {
  return { ...view, x: Math.min(x1, Math.max(x0, x)), y: Math.min(y1, Math.max(y0, y)) };
}
