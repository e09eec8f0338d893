/** Lengths, directions and areas of measurements on a map, and the cell borders to which points snap. */

import { thresholds } from "../../grid/cellValues";
import { cellAt, contains, fromLattice, toLattice } from "../../grid/lattice";
import { byteOfCost } from "../../render/map/costColours";
import type { MapPicture } from "../../render/map/mapPicture";
import { written } from "../../ui/numbers";
import type { Point } from "../../wire/protocol";

/** A measured point, m: on a map without a height, in 3D with one. */
export type Spot = readonly [x: number, y: number, z?: number];

const heightOf = ([, , z = 0]: Spot): number => z;

const between = (from: Spot, to: Spot): readonly [number, number, number] => [
  to[0] - from[0],
  to[1] - from[1],
  heightOf(to) - heightOf(from),
];

export const distanceOf = (from: Spot, to: Spot): number => Math.hypot(...between(from, to));

/** The length of a line of points, m; the perimeter of a polygon if it is closed. */
export function lengthOf(points: readonly Spot[], isClosed = false): number {
  let sum = 0;
  for (let i = isClosed ? 0 : 1; i < points.length; i++) {
    sum += distanceOf(points.at(i - 1) as Spot, points[i] as Spot);
  }
  return sum;
}

/**
 * The area of a polygon, m²: the shoelace formula in each plane of two axes. If its corners are not coplanar, it is the
 * greatest area of its parallel projections.
 */
export function areaOf(points: readonly Spot[]): number {
  const twice: [number, number, number] = [0, 0, 0];
  for (let i = 0; i < points.length; i++) {
    const [[x0, y0, z0 = 0], [x1, y1, z1 = 0]] = [points.at(i - 1) as Spot, points[i] as Spot];
    twice[0] += y0 * z1 - y1 * z0;
    twice[1] += z0 * x1 - z1 * x0;
    twice[2] += x0 * y1 - x1 * y0;
  }
  return Math.hypot(...twice) / 2;
}

/** The direction from one point to another, degrees counter-clockwise from x, −180 to 180. */
export const headingOf = ([x0, y0]: Spot, [x1, y1]: Spot): number => (Math.atan2(y1 - y0, x1 - x0) * 180) / Math.PI;

/** The angle at the middle of three points, degrees, 0 to 180. */
export function angleAt(before: Spot, at: Spot, after: Spot): number {
  const [x0, y0, z0] = between(at, before);
  const [x1, y1, z1] = between(at, after);
  const across = Math.hypot(y0 * z1 - y1 * z0, z0 * x1 - z1 * x0, x0 * y1 - x1 * y0);
  return (Math.atan2(across, x0 * x1 + y0 * y1 + z0 * z1) * 180) / Math.PI;
}

/** The measurement in words; `size` is the side of a cell or a voxel, m, 0 if the points themselves are known. */
export function measuredText(tool: "distance" | "area", points: readonly Spot[], size: number): string {
  const cell = size > 0 ? ` ± ${written(size, 2)} m` : ""; // each end is within half a cell of the wall
  if (tool === "area") {
    if (points.length < 3) return "Click the corners of an area.";
    return `${written(areaOf(points), 2)} m², around it ${written(lengthOf(points, true), 2)} m${cell}`;
  }
  const last = points.at(-1);
  const before = points.at(-2);
  if (!last || !before) return "Click two places, or two sides of a door.";
  const corner = points.at(-3);
  const isFlat = points.every(([, , z]) => z === undefined);
  const rise = isFlat ? "" : `, height difference ${written(heightOf(last) - heightOf(before), 2)} m`;
  const own = `${written(distanceOf(before, last), 2)} m${cell}${rise}`;
  if (!corner) return `${own}, direction ${written(headingOf(before, last), 1)}°`;
  return `${own}, angle ${written(angleAt(corner, before, last), 1)}°, together ${written(lengthOf(points), 2)} m`;
}

/** Cost of a cell of Nav2's costmaps in which the robot's centre is in collision, but which is not an obstacle. */
const INSCRIBED = 253;

/** The byte above which a cell contains a surface: it is occupied, or in a recorded costmap lethal. */
export const surfacesAbove = ({ style, geometry }: MapPicture): number =>
  style === "recorded_costs" ? byteOfCost(INSCRIBED) : thresholds(geometry).above;

/**
 * The nearest place, within `reach` metres of a point, on a border between an occupied cell and one that is not; null
 * if there is none. These are the only places at which the map indicates a surface.
 */
export function snapped(map: MapPicture, point: Point, reach: number): Point | null {
  const { geometry, cells } = map;
  const { resolution } = geometry;
  const above = surfacesAbove(map);
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

/** The longest of 1, 2 and 5 times a power of ten, m, that takes at most `pixels` at this scale, metres per pixel. */
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
