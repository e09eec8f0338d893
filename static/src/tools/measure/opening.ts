/** The free width between two walls that face each other, such as the jambs of a door. */

import { cellAt, contains, fromLattice, toLattice } from "../../grid/lattice";
import type { MapPicture } from "../../render/map/mapPicture";
import type { Point } from "../../wire/protocol";
import { surfacesAbove } from "./model";

/** The side of an occupied cell towards one that is not, in cells: its middle, and its direction. */
interface Border {
  readonly u: number;
  readonly v: number;
  readonly isVertical: boolean;
}

/** Walls are taken as facing each other where their borders are within this of the narrowest place, cells. */
const ROUGHNESS = 1;

/**
 * Two places near two points between which lies the opening between walls that face each other, not a slanting line
 * through it: of the distances between borders of occupied cells that face each other, the middle one of those that are
 * a cell at most above the least. As a surface is anywhere in its cell, either end is half a cell behind its border.
 * Null where there are no such borders within `reach` metres of both points, or the cells between are not free.
 */
export function opening(map: MapPicture, from: Point, to: Point, reach: number): readonly [Point, Point] | null {
  const { geometry } = map;
  const cells = reach / geometry.resolution;
  const a = toLattice(geometry, from[0], from[1]);
  const b = toLattice(geometry, to[0], to[1]);
  const there = bordersNear(map, from, cells, [b[0] - a[0], b[1] - a[1]]);
  const back = bordersNear(map, to, cells, [a[0] - b[0], a[1] - b[1]]);
  const pairs = there
    .flatMap((p) => {
      const near = back.map((q) => nearestOn(q, p)).sort((one, other) => one.far - other.far)[0];
      return near ? [{ p, ...near }] : [];
    })
    .sort((one, other) => one.far - other.far);
  const least = pairs[0]?.far ?? 0;
  const facing = pairs.filter(({ far }) => far <= least + ROUGHNESS);
  const middle = facing[(facing.length - 1) >> 1];
  if (!middle || middle.far < 1 || !isFree(map, middle.p, middle)) return null;
  const [u, v] = [(middle.u - middle.p.u) / middle.far, (middle.v - middle.p.v) / middle.far];
  const depth = (Math.abs(u) + Math.abs(v)) / 2; // half of a cell's extent in that direction
  return [
    fromLattice(geometry, middle.p.u - depth * u, middle.p.v - depth * v),
    fromLattice(geometry, middle.u + depth * u, middle.v + depth * v),
  ];
}

function bordersNear(map: MapPicture, point: Point, reach: number, [du, dv]: readonly [number, number]): Border[] {
  const { geometry } = map;
  const centre = cellAt(geometry, point[0], point[1]);
  const [u, v] = toLattice(geometry, point[0], point[1]);
  const around = Math.ceil(reach);
  const found: Border[] = [];
  for (let row = centre.row - around; row <= centre.row + around; row++) {
    for (let col = centre.col - around; col <= centre.col + around; col++) {
      if (!isOccupied(map, row, col)) continue;
      for (const [r, c] of [
        [0, 1],
        [0, -1],
        [1, 0],
        [-1, 0],
      ] as const) {
        if (c * du + r * dv <= 0 || isOccupied(map, row + r, col + c)) continue;
        const border = { u: col + 0.5 + c / 2, v: row + 0.5 + r / 2, isVertical: c !== 0 };
        if (Math.hypot(border.u - u, border.v - v) <= reach) found.push(border);
      }
    }
  }
  return found;
}

/** The place on a border that is nearest to a point, and how far it is. */
function nearestOn(border: Border, { u, v }: { readonly u: number; readonly v: number }) {
  const on = border.isVertical
    ? { u: border.u, v: Math.min(border.v + 0.5, Math.max(border.v - 0.5, v)) }
    : { u: Math.min(border.u + 0.5, Math.max(border.u - 0.5, u)), v: border.v };
  return { ...on, far: Math.hypot(on.u - u, on.v - v) };
}

function isOccupied(map: MapPicture, row: number, col: number): boolean {
  return contains(map.geometry, { row, col }) && map.cells.at(row, col) > surfacesAbove(map);
}

interface Place {
  readonly u: number;
  readonly v: number;
}

/** Whether the cells between two places are free of walls, but for those that the places are on. */
function isFree(map: MapPicture, from: Place, to: Place): boolean {
  const length = Math.hypot(to.u - from.u, to.v - from.v);
  for (let at = 0.75; at < length - 0.75; at += 0.25) {
    const [u, v] = [from.u + (at / length) * (to.u - from.u), from.v + (at / length) * (to.v - from.v)];
    if (isOccupied(map, Math.floor(v), Math.floor(u))) return false;
  }
  return true;
}
