/** Clicks and keys of a picture while something is measured. */

import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { measuringOf } from "./measuring";
import { snapped } from "./model";
import { opening } from "./opening";

const SNAP_PX = 12;
/** Walls that face each other are looked for this far from either end at most. */
const MOST_REACH_M = 0.4;

/** The place that a click at a point means: on the border of a wall near it, if it snaps to one. */
export function placeAt(store: Store, point: Point): Point {
  const [map, reach] = [store.map.peek(), reachOf(store)];
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
function endsAt(store: Store, from: Point, to: Point): readonly [Point, Point] {
  const [map, reach] = [store.map.peek(), reachOf(store)];
  const cells = map && reach !== null ? Math.min(Math.max(reach, 2.5 * map.geometry.resolution), MOST_REACH_M) : 0;
  return (map && cells > 0 && opening(map, from, to, cells)) || [from, to];
}

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
    const place = placeAt(store, point);
    const [first, ...more] = measuring.isDone.peek() ? [] : measuring.points.peek();
    if (measuring.tool.peek() === "distance" && first && more.length === 0) {
      measuring.points.value = endsAt(store, first, place);
    } else measuring.add(place);
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
