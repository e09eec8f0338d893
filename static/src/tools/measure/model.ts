/** Lengths, directions and areas of what is measured on a map, and the borders of cells that points snap to. */

import { thresholds } from "../../grid/cellValues";
import { cellAt, contains, fromLattice, toLattice } from "../../grid/lattice";
import type { MapPicture } from "../../render/map/mapPicture";
import { written } from "../../ui/numbers";
import type { Point } from "../../wire/protocol";

export const distanceOf = ([x0, y0]: Point, [x1, y1]: Point): number => Math.hypot(x1 - x0, y1 - y0);

/** The length of a line of points, m; of a polygon where it is closed. */
export function lengthOf(points: readonly Point[], isClosed = false): number {
  let sum = 0;
  for (let i = isClosed ? 0 : 1; i < points.length; i++) {
    sum += distanceOf(points.at(i - 1) as Point, points[i] as Point);
  }
  return sum;
}

/** The area of a polygon, m²: the shoelace formula. */
export function areaOf(points: readonly Point[]): number {
  let twice = 0;
  for (let i = 0; i < points.length; i++) {
    const [[x0, y0], [x1, y1]] = [points.at(i - 1) as Point, points[i] as Point];
    twice += x0 * y1 - x1 * y0;
  }
  return Math.abs(twice) / 2;
}

/** The direction from one point to another, degrees counter-clockwise from x, −180 … 180. */
export const headingOf = ([x0, y0]: Point, [x1, y1]: Point): number => (Math.atan2(y1 - y0, x1 - x0) * 180) / Math.PI;

/** The angle at the middle of three points, degrees 0 … 180. */
export function angleAt(before: Point, at: Point, after: Point): number {
  const turned = Math.abs(headingOf(at, before) - headingOf(at, after));
  return turned > 180 ? 360 - turned : turned;
}

/** What is measured, in words; `resolution` is the side of a cell, m. */
export function measuredText(tool: "distance" | "area", points: readonly Point[], resolution: number): string {
  const cell = `± ${written(resolution, 2)} m`; // each end lies within half a cell of the wall
  if (tool === "area") {
    if (points.length < 3) return "Click the corners of an area.";
    return `${written(areaOf(points), 2)} m², around it ${written(lengthOf(points, true), 2)} m ${cell}`;
  }
  const last = points.at(-1);
  const before = points.at(-2);
  if (!last || !before) return "Click two places, or two sides of a door.";
  const corner = points.at(-3);
  const own = `${written(distanceOf(before, last), 2)} m ${cell}`;
  if (!corner) return `${own}, direction ${written(headingOf(before, last), 1)}°`;
  return `${own}, angle ${written(angleAt(corner, before, last), 1)}°, together ${written(lengthOf(points), 2)} m`;
}

/**
 * The nearest place, within `reach` metres of a point, on a border between an occupied cell and one that is not; null
 * where there is none. These are the only places at which the map says that a surface is.
 */
export function snapped(map: MapPicture, point: Point, reach: number): Point | null {
  const { geometry, cells } = map;
  const { resolution } = geometry;
  const { above } = thresholds(geometry);
  const [u, v] = toLattice(geometry, point[0], point[1]);
  const centre = cellAt(geometry, point[0], point[1]);
  const around = Math.ceil(reach / resolution);
  const isOccupied = (row: number, col: number): boolean =>
    contains(geometry, { row, col }) && cells.at(row, col) > above;
  let best: Point | null = null;
  let least = reach / resolution;
  for (let row = centre.row - around; row <= centre.row + around; row++) {
    for (let col = centre.col - around; col <= centre.col + around; col++) {
      const own = isOccupied(row, col);
      // Each border once: that to the cell on the right, and that to the cell above.
      if (own !== isOccupied(row, col + 1)) take(col + 1, clamp(v, row, row + 1));
      if (own !== isOccupied(row + 1, col)) take(clamp(u, col, col + 1), row + 1);
    }
  }
  return best;

  function take(onU: number, onV: number): void {
    const far = Math.hypot(onU - u, onV - v);
    if (far >= least) return;
    least = far;
    best = fromLattice(geometry, onU, onV);
  }
}

const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

/** The longest of 1, 2 and 5 times a power of ten, m, that is at most `pixels` wide at so many metres a pixel. */
export function scaleBar(metresPerPixel: number, pixels: number): number {
  const most = metresPerPixel * pixels;
  const power = 10 ** Math.floor(Math.log10(most));
  return power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
}

/** A length of a scale bar as text: 2 m, 50 cm, 1 km. */
export function scaleText(metres: number): string {
  if (metres >= 1000) return `${metres / 1000} km`;
  return metres >= 1
    ? `${metres} m`
    : metres >= 0.01
      ? `${Math.round(metres * 100)} cm`
      : `${Math.round(metres * 1000)} mm`;
}
