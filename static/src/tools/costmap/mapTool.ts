/** The costmap's tools in the pictures: set the goal, paint keepout zones and speed limits, query a cost. */

import type { Store } from "../../store/store";
import type { BrushStroke, Point } from "../../wire/protocol";
import { pathOf } from "../path/state";
import { costmapOf } from "./state";

/** Least distance between two points of a stroke, as a share of the brush's width. */
const SPACING = 0.25;
const MOST_POINTS = 300;
const GRAB_PX = 14;

const isBrush = (store: Store): boolean => {
  const tool = costmapOf(store).tool.peek();
  return tool === "keepout" || tool === "speed" || tool === "erase";
};

/** Whether a drag in a picture paints. */
export const paints = (store: Store): boolean =>
  isBrush(store) && costmapOf(store).costmap.peek()?.is_on === true && store.editing.tool.peek() === null;

/** Use the tool at a clicked place; false if there is none. */
export function useTool(store: Store, point: Point): boolean {
  const state = costmapOf(store);
  const tool = state.tool.peek();
  if (tool === null || !state.costmap.peek()?.is_on || store.editing.tool.peek() !== null) return false;
  if (tool === "goal") pathOf(store).setGoal(point);
  else if (tool === "cost") state.asked.value = point;
  else {
    continueStroke(store, point, point);
    endStroke(store);
  }
  return true;
}

/** Whether the goal is drawn near a place on the screen; `at` returns the screen position of a point. */
export function isOnGoal(store: Store, x: number, y: number, reach: number, at: (point: Point) => Point): boolean {
  const goal = pathOf(store).path.peek()?.goal;
  if (!goal || !costmapOf(store).costmap.peek()?.is_on) return false;
  const [gx, gy] = at(goal);
  return Math.hypot(x - gx, y - gy) <= GRAB_PX + reach;
}

/** A stroke of the brush from `from` so far to `to`, null if it was cancelled. */
export function brushStroke(store: Store, from: Point | null, to: Point | null, isDone: boolean): void {
  if (!from || !to) {
    cancel(store);
    return;
  }
  continueStroke(store, from, to);
  if (isDone) endStroke(store);
}

const rounded = ([x, y]: Point): Point => [Math.round(x * 1000) / 1000, Math.round(y * 1000) / 1000];

function continueStroke(store: Store, from: Point, to: Point): void {
  const state = costmapOf(store);
  const width = state.brush.peek();
  const tool = state.tool.peek();
  const before = state.stroke.peek();
  const points = before?.points ?? [rounded(from)];
  const last = points.at(-1) ?? from;
  const isFar = Math.hypot(to[0] - last[0], to[1] - last[1]) >= SPACING * width;
  if (before && (!isFar || points.length >= MOST_POINTS)) return;
  if (!before) state.painted.value = state.costmap.peek()?.keepout ?? [];
  const stroke: BrushStroke = {
    width,
    erases: tool === "erase",
    ...(tool === "speed" ? { speed: state.limit.peek() } : {}),
    points: isFar ? [...points, rounded(to)] : points,
  };
  state.stroke.value = stroke;
  store.sendSoon({ type: "costmap", keepout: [...state.painted.peek(), stroke] });
}

function endStroke(store: Store): void {
  const { stroke, painted } = costmapOf(store);
  const made = stroke.peek();
  if (made) costmapOf(store).setKeepout([...painted.peek(), made], painted.peek());
  stroke.value = null;
}

function cancel(store: Store): void {
  const { stroke, painted } = costmapOf(store);
  if (!stroke.peek()) return;
  stroke.value = null;
  store.sendSoon({ type: "costmap", keepout: painted.peek() });
}
