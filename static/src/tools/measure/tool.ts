/** Clicks and keys of a picture while something is measured. */

import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { measuringOf } from "./measuring";
import { snapped } from "./model";

const SNAP_PX = 12;

/** The place that a click at a point means: on the border of a wall near it, if it snaps to one. */
export function placeAt(store: Store, point: Point): Point {
  const [map, view] = [store.map.peek(), store.view.peek()];
  if (!map || !view || !measuringOf(store).snaps.peek()) return point;
  const reach = Math.max(SNAP_PX * view.scale, 0.75 * map.geometry.resolution);
  // Far out a cell is less than a pixel, and a search over thousands of them would take longer than a frame.
  return reach > 60 * map.geometry.resolution ? point : (snapped(map, point, reach) ?? point);
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
    measuring.add(placeAt(store, point));
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
