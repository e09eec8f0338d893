/** Clicks and keys of a picture while something is measured. */

import { effect, untracked } from "@preact/signals";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { measuringOf } from "./measuring";
import { snapped } from "./model";
import { opening } from "./opening";

const SNAP_PX = 12;
/** Walls that face each other are looked for this far from either end at most. */
const MOST_REACH_M = 0.4;

/** Walls are looked for this far from a click in 3D, cells: it may be on the side of one. */
const CELLS_IN_3D = 2.5;

/** The place that a click at a point means: on the border of a wall within `reach` metres, if it snaps to one. */
export function placeAt(store: Store, point: Point, reach = reachOf(store)): Point {
  const map = store.map.peek();
  return map && reach !== null ? (snapped(map, point, reach) ?? point) : point;
}

/** How far from a click walls are looked for, m; null where they are not. */
function reachOf(store: Store): number | null {
  const [map, view] = [store.map.peek(), store.view.peek()];
  if (!map || !view || !measuringOf(store).snaps.peek()) return null;
  const reach = Math.max(SNAP_PX * view.scale, 0.75 * map.geometry.resolution);
  // Far out a cell is less than a pixel, and a search over thousands of them would take longer than a frame.
  return reach > 60 * map.geometry.resolution ? null : reach;
}

/** The two ends of a line to a second point: those of the opening there, such as a door, if it snaps to one. */
function endsAt(store: Store, from: Point, to: Point, reach: number | null): readonly [Point, Point] {
  const map = store.map.peek();
  const cells = map && reach !== null ? Math.min(Math.max(reach, 2.5 * map.geometry.resolution), MOST_REACH_M) : 0;
  return (map && cells > 0 && opening(map, from, to, cells)) || [from, to];
}

/** Measure to a place of a map, on the border of a wall within `reach` metres of it; null: anywhere. */
function addPlace(store: Store, point: Point, reach: number | null): void {
  const measuring = measuringOf(store);
  const place = placeAt(store, point, reach);
  const [first, ...more] = measuring.isDone.peek() ? [] : measuring.points.peek();
  if (measuring.tool.peek() === "distance" && first && first[2] === undefined && more.length === 0) {
    measuring.points.value = endsAt(store, [first[0], first[1]], place, reach);
  } else measuring.add(place);
}

/** Shows what is measured in the 3D views of the page, and takes the places that are clicked in them. */
class InScenes {
  constructor(store: Store) {
    const measuring = measuringOf(store);
    let wasOn = false;
    effect(() => {
      void store.hello.value; // of a new connection, which knows of nothing
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

/** Measure in the 3D views of the page, too. */
export const measureInScenes = (store: Store): void => void store.of(InScenes);

/** Takes the clicks and keys of a picture while something is measured. */
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
