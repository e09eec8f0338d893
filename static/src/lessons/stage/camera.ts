/** The part of the floor that the stage shows, and the way from one part to another. */

/** What the camera shows: a box of the floor, and the strip beside it. */
export interface View extends Box {
  /** How much of the strip with a cell's history is shown beside the map: 0 none, 1 all of it. */
  readonly strip: number;
}

/** A box of the floor, metres: its centre, and the width and height that have to be visible. */
export interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** The eased fraction of the way after the fraction `t` of the time. */
export const eased = (t: number): number => t * t * (3 - 2 * t);

/**
 * The view at fraction `t` between two views. The scale changes by equal factors in equal times, and the centre moves
 * in proportion to the change of the width, so that one point of the picture stands still while it zooms.
 */
export function between(from: View, to: View, t: number): View {
  const width = from.width * (to.width / from.width) ** t;
  const height = from.height * (to.height / from.height) ** t;
  const ratio = to.width / from.width;
  const fraction = Math.abs(Math.log(ratio)) < 0.05 ? t : (width - from.width) / (to.width - from.width);
  const strip = from.strip + t * (to.strip - from.strip);
  return { x: from.x + fraction * (to.x - from.x), y: from.y + fraction * (to.y - from.y), width, height, strip };
}

/** A rectangle of the screen, CSS pixels. */
export interface Rect {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** Metres to pixels and back, for a view that is fitted into a rectangle of the screen. y points up on the floor. */
export interface Projection {
  readonly rect: Rect;
  /** Pixels of a metre. */
  readonly metre: number;
  x(metres: number): number;
  y(metres: number): number;
  world(px: number, py: number): readonly [number, number];
}

export function projection(view: Box, rect: Rect): Projection {
  const metre = Math.min(rect.width / view.width, rect.height / view.height);
  const [cx, cy] = [rect.left + rect.width / 2, rect.top + rect.height / 2];
  return {
    rect,
    metre,
    x: (metres) => cx + (metres - view.x) * metre,
    y: (metres) => cy - (metres - view.y) * metre,
    world: (px, py) => [view.x + (px - cx) / metre, view.y - (py - cy) / metre],
  };
}
