/** The effect of the editing tools on a store's world, by pointer and by keyboard. */

import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { clampedToWorld, editsWithout, shapeOfStroke, solidAt } from "./shapes";

/** Distance from a solid at which the eraser still selects it, CSS pixels. */
const ERASER_PX = 10;

/** A stroke of the selected tool: a sketch while it lasts, an edit when it is done, nothing if it is cancelled. */
export function stroke(store: Store, from: Point | null, to: Point | null, isDone: boolean): void {
  const { editing } = store;
  const world = store.world.peek();
  const tool = editing.tool.peek();
  if (!world || !from || !to || (tool !== "wall" && tool !== "box")) {
    editing.sketch.value = null;
    return;
  }
  const made = shapeOfStroke(tool, clampedToWorld(from, world.bounds), clampedToWorld(to, world.bounds));
  editing.sketch.value = made;
  if (isDone && made) store.edit({ added: [...world.edits.added, made], erased: world.edits.erased });
}

/** The polygon that the eraser would select at a place; null for none. */
export function underEraser(store: Store, point: Point | null): number | null {
  const world = store.world.peek();
  const view = store.view.peek();
  if (!world || !view || !point || store.editing.tool.peek() !== "erase") return null;
  return solidAt(world, point, ERASER_PX * view.scale);
}

/** The edit by a click on a place of the world, or Enter at the keyboard's cursor, with the selected tool. */
export function editAt(store: Store, point: Point, isKey: boolean): void {
  const { editing } = store;
  const world = store.world.peek();
  if (editing.tool.peek() === "erase") {
    const polygon = underEraser(store, point);
    if (world && polygon !== null) store.edit(editsWithout(world, polygon));
  } else if (isKey) {
    const corner = editing.corner.peek();
    if (corner) stroke(store, corner, point, true);
    editing.corner.value = corner ? null : point;
  }
}
