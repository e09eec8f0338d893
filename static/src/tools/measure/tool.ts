/** Clicks and keys of a picture during a measurement. */

import { effect, untracked } from "@preact/signals";
import { cellAt, contains, fromLattice, toLattice } from "../../grid/lattice";
import type { MapPicture } from "../../render/map/mapPicture";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { measuringOf } from "./measuring";
import { snapped, surfacesAbove } from "./model";

/** The side of an occupied cell towards one that is not, in cells: its middle and its direction. */
interface Border {
  readonly u: number;
  readonly v: number;
  readonly isVertical: boolean;
}

/** Walls count as facing each other where their borders are within this distance of the narrowest place, cells. */
const ROUGHNESS = 1;

/**
 * The two ends of the opening between facing walls near two points, instead of a slanting line through it. Of the
 * distances between facing borders of occupied cells, it uses the median of those that are at most one cell above the
 * least. Because a surface is anywhere in its cell, each end is half a cell behind its border. Null if there are no
 * such borders within `reach` metres of both points, or the cells between are not free.
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
      const near = back.map((q) => nearestOn(q, p)).sort((match, other) => match.far - other.far)[0];
      return near ? [{ p, ...near }] : [];
    })
    .sort((match, other) => match.far - other.far);
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
  const borders: Border[] = [];
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
        if (Math.hypot(border.u - u, border.v - v) <= reach) borders.push(border);
      }
    }
  }
  return borders;
}

/** The nearest place on a border to a point, and its distance. */
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

/** Whether the cells between two places are free of walls, except the cells that contain the places. */
function isFree(map: MapPicture, from: Place, to: Place): boolean {
  const length = Math.hypot(to.u - from.u, to.v - from.v);
  for (let at = 0.75; at < length - 0.75; at += 0.25) {
    const [u, v] = [from.u + (at / length) * (to.u - from.u), from.v + (at / length) * (to.v - from.v)];
    if (isOccupied(map, Math.floor(v), Math.floor(u))) return false;
  }
  return true;
}

const SNAP_PX = 12;
/** Greatest distance from either end at which facing walls are searched. */
const MOST_REACH_M = 0.4;

/** Distance from a click in 3D at which walls are searched, cells, because it may be on the side of one. */
const CELLS_IN_3D = 2.5;

/** The place selected by a click at a point: on the border of a wall within `reach` metres, if it snaps to one. */
export function placeAt(store: Store, point: Point, reach = reachOf(store)): Point {
  const map = store.map.peek();
  return map && reach !== null ? (snapped(map, point, reach) ?? point) : point;
}

/** Distance from a click at which walls are searched, m; null if they are not. */
function reachOf(store: Store): number | null {
  const [map, view] = [store.map.peek(), store.view.peek()];
  if (!map || !view || !measuringOf(store).snaps.peek()) return null;
  const reach = Math.max(SNAP_PX * view.scale, 0.75 * map.geometry.resolution);
  // When zoomed out, a cell is less than a pixel, and searching thousands of them would take longer than a frame.
  return reach > 60 * map.geometry.resolution ? null : reach;
}

/** The two ends of a line to a second point: those of an opening there, such as a door, if it snaps to one. */
function endsAt(store: Store, from: Point, to: Point, reach: number | null): readonly [Point, Point] {
  const map = store.map.peek();
  const cells = map && reach !== null ? Math.min(Math.max(reach, 2.5 * map.geometry.resolution), MOST_REACH_M) : 0;
  return (map && cells > 0 && opening(map, from, to, cells)) || [from, to];
}

/** Measure to a place on a map, on the border of a wall within `reach` metres of it; null: anywhere. */
function addPlace(store: Store, point: Point, reach: number | null): void {
  const measuring = measuringOf(store);
  const place = placeAt(store, point, reach);
  const [first, ...more] = measuring.isDone.peek() ? [] : measuring.points.peek();
  if (measuring.tool.peek() === "distance" && first && first[2] === undefined && more.length === 0) {
    measuring.points.value = endsAt(store, [first[0], first[1]], place, reach);
  } else measuring.add(place);
}

/** Shows the measurement in the page's 3D views, and handles places clicked in them. */
class InScenes {
  constructor(store: Store) {
    const measuring = measuringOf(store);
    let wasOn = false;
    effect(() => {
      void store.hello.value; // of a new connection, which has no state yet
      const tool = measuring.tool.value;
      const points = measuring.points.value.map(([x, y, z = 0]) => [x, y, z] as const);
      if (tool) store.send({ type: "measure", points, closed: tool === "area" });
      else if (wasOn) store.send({ type: "measure" });
      wasOn = tool !== null;
    });
    const { message } = store.part("place");
    let taken = message.peek();
    effect(() => {
      const place = message.value;
      if (!place || place === taken) return;
      taken = place;
      untracked(() => {
        if (measuring.tool.peek() === null) return;
        if (place.z !== null) measuring.add([place.x, place.y, place.z], place.size);
        else addPlace(store, [place.x, place.y], reachIn3d(store));
      });
    });
  }
}

function reachIn3d(store: Store): number | null {
  const map = store.map.peek();
  return map && measuringOf(store).snaps.peek() ? CELLS_IN_3D * map.geometry.resolution : null;
}

/** Measure in the page's 3D views, too. */
export const measureInScenes = (store: Store): void => void store.of(InScenes);

/** Handles the clicks and keys of a picture during a measurement. */
export function measuringTool(store: Store): {
  readonly draws: () => boolean;
  readonly stroke: () => void;
  readonly tap: (point: Point) => boolean;
  readonly key: (key: string) => boolean;
} {
  const measuring = measuringOf(store);
  const tap = (point: Point): boolean => {
    if (measuring.tool.peek() === null) return false;
    addPlace(store, point, reachOf(store));
    return true;
  };
  const key = (pressed: string): boolean => {
    if (measuring.tool.peek() === null) return false;
    if (pressed === "Enter") {
      const cursor = store.pinned.peek();
      if (cursor) tap(cursor);
    } else if (pressed === "Backspace") measuring.undo();
    else if (pressed === "Escape" && measuring.points.peek().length > 0) measuring.clear();
    else if (pressed === "Escape") measuring.take(null);
    else return false;
    return true;
  };
  return { draws: () => false, stroke: () => undefined, tap, key };
}
