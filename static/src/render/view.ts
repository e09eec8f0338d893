/**
 * The part of the world that a picture shows. The pictures of the lab share one view, so that a point of the world is
 * at the same pixel in each. World coordinates are metres, x right and y up; screen coordinates are CSS pixels from
 * the upper left corner of the picture.
 */

import type { Bounds } from "../grid/lattice";
import type { Point } from "../wire/protocol";

export interface View {
  /** The world point at the centre of the picture. */
  readonly x: number;
  readonly y: number;
  /** Metres per CSS pixel. */
  readonly scale: number;
}

export interface Size {
  readonly width: number;
  readonly height: number;
}

export const MIN_SCALE = 0.0005;
export const MAX_SCALE = 10;

const limited = (scale: number): number => Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale));

export function toScreen(view: View, size: Size, x: number, y: number): Point {
  return [size.width / 2 + (x - view.x) / view.scale, size.height / 2 - (y - view.y) / view.scale];
}

export function toWorld(view: View, size: Size, px: number, py: number): Point {
  return [view.x + (px - size.width / 2) * view.scale, view.y - (py - size.height / 2) * view.scale];
}

/** The view after the picture was moved by (dx, dy) pixels. */
export function panned(view: View, dx: number, dy: number): View {
  return { ...view, x: view.x - dx * view.scale, y: view.y + dy * view.scale };
}

/** The view enlarged by `factor` about a pixel: the world point under that pixel stays there. */
export function zoomedAt(view: View, size: Size, px: number, py: number, factor: number): View {
  const scale = limited(view.scale / factor);
  const [x, y] = toWorld(view, size, px, py);
  return { x: x - (px - size.width / 2) * scale, y: y + (py - size.height / 2) * scale, scale };
}

/** Pixels around a whole box, and the share of a small picture's shorter side. */
const MARGIN = 16;
const MARGIN_SHARE = 0.04;

/** The view that shows a whole box with `margin` pixels around it; by default fewer in a small picture. */
export function fitted(
  bounds: Bounds,
  size: Size,
  margin = Math.min(MARGIN, MARGIN_SHARE * Math.min(size.width, size.height)),
): View {
  const [x0, y0, x1, y1] = bounds;
  const width = Math.max(1, size.width - 2 * margin);
  const height = Math.max(1, size.height - 2 * margin);
  return {
    x: (x0 + x1) / 2,
    y: (y0 + y1) / 2,
    scale: limited(Math.max((x1 - x0) / width, (y1 - y0) / height)),
  };
}

/** A view with the size of its picture, so that a picture of another size can show the same part of the world. */
export interface SharedView extends View, Size {}

/** The view that contains all of a shared view; the same view if the pictures have the same size. */
export function framed(shared: SharedView, size: Size): View {
  const smaller = Math.max(shared.width / size.width, shared.height / size.height);
  return { x: shared.x, y: shared.y, scale: limited(shared.scale * smaller) };
}
