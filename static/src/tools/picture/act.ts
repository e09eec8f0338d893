import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { useTool } from "../costmap/mapTool";
import { editAt } from "../editing/strokes";

/**
 * What a click on a place of the world does, or Enter at the keyboard's cursor (`isKey`): the selected tool edits the
 * world there; without one the robot is placed there.
 */
export function act(store: Store, point: Point, isKey = false): void {
  if (useTool(store, point)) return;
  if (store.editing.tool.peek() === null) store.teleport(point);
  else editAt(store, point, isKey);
}
