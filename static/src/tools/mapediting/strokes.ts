/** The drawings of the map editing tools, and the commands that they send. */

import type { Store } from "../../store/store";
import type { MapEditCommand, Point } from "../../wire/protocol";
import type { MapTool, PaintedState } from "./state";
import { mapEditingOf } from "./state";

/** A line closer than this to vertical or horizontal is aligned, rad. */
const STRAIGHT = 0.09;
/** Points of a stroke: a command has at most 64 KiB. */
const MOST_POINTS = 2500;
/** Least distance between two points of a stroke, CSS pixels. */
const SPACING_PX = 3;
/** A smaller rectangle or direction is ignored as unintentional, CSS pixels. */
const LEAST_PX = 4;
const QUARTER = Math.PI / 2;

/** How a tool draws, and the effect of its drawing. */
export interface Drawing {
  readonly tool: MapTool;
  readonly state: PaintedState;
  readonly width: number;
  readonly isFreehand: boolean;
  readonly allows: boolean;
  readonly limit: number;
}

export const drawingOf = (store: Store): Drawing | null => {
  const { tool, state, width, isFreehand, allows, limit } = mapEditingOf(store);
  const now = tool.peek();
  return (
    now && {
      tool: now,
      state: state.peek(),
      width: width.peek(),
      isFreehand: isFreehand.peek(),
      allows: allows.peek(),
      limit: limit.peek(),
    }
  );
};

/** Whether all points of the pointer count, not only the first and the last. */
export const isFree = ({ tool, isFreehand }: Drawing): boolean =>
  tool === "brush" || (isFreehand && (tool === "area" || tool === "keepout" || tool === "speed"));

const rounded = (value: number): number => Math.round(value * 1e4) / 1e4;
const place = ([x, y]: Point): Point => [rounded(x), rounded(y)];

/** The line's end, aligned if the line is nearly horizontal or vertical. */
export function straightened([x0, y0]: Point, [x, y]: Point): Point {
  const [dx, dy] = [Math.abs(x - x0), Math.abs(y - y0)];
  if (dy < dx * Math.tan(STRAIGHT)) return [x, y0];
  if (dx < dy * Math.tan(STRAIGHT)) return [x0, y];
  return [x, y];
}

const rectangle = ([x0, y0]: Point, [x1, y1]: Point): readonly Point[] => [
  [x0, y0],
  [x1, y0],
  [x1, y1],
  [x0, y1],
];

/** The angle by which the map must be rotated to align a line with the nearest axis, rad. */
export function turnOf([x0, y0]: Point, [x1, y1]: Point): number {
  const angle = Math.atan2(y1 - y0, x1 - x0);
  return Math.round(angle / QUARTER) * QUARTER - angle;
}

/** The final outline of the drawing: a line, or a polygon. */
export function shapeOf(drawing: Drawing, points: readonly Point[]): readonly Point[] {
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last || isFree(drawing)) return points;
  if (drawing.tool === "line") return [first, straightened(first, last)];
  return drawing.tool === "straighten" || drawing.tool === "origin" ? [first, last] : rectangle(first, last);
}

/** The command for a drawing; null if it was unintentional. `scale` is metres per CSS pixel. */
export function commandOf(drawing: Drawing, points: readonly Point[], scale: number): MapEditCommand | null {
  const shape = shapeOf(drawing, points).map(place);
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last) return null;
  const [width, height] = [Math.abs(last[0] - first[0]), Math.abs(last[1] - first[1])];
  const isSmall = isFree(drawing) ? shape.length < 3 : Math.min(width, height) < LEAST_PX * scale;
  const isShort = Math.hypot(width, height) < LEAST_PX * scale;
  const { tool, state } = drawing;
  switch (tool) {
    case "brush":
    case "line":
      return { type: "map_edit", op: "paint", state, width: rounded(drawing.width), points: shape };
    case "area":
      return isSmall ? null : { type: "map_edit", op: "fill", state, points: shape };
    case "keepout":
      return isSmall ? null : { type: "map_edit", op: "keepout", value: drawing.allows ? 0 : 100, points: shape };
    case "speed":
      return isSmall ? null : { type: "map_edit", op: "speed", value: Math.round(drawing.limit), points: shape };
    case "straighten":
      return isShort ? null : { type: "map_edit", op: "rotate", angle: turnOf(first, last) };
    case "crop":
      return isSmall ? null : { type: "map_edit", op: "crop", points: [place(first), place(last)] };
    case "origin": {
      const angle = isShort ? 0 : Math.atan2(last[1] - first[1], last[0] - first[0]);
      return { type: "map_edit", op: "origin", points: [place(first)], angle };
    }
  }
}

/** A stroke of the pointer from `from` so far to `to`, null if it was cancelled. */
export function stroke(store: Store, from: Point | null, to: Point | null, isDone: boolean): void {
  const mapEditing = mapEditingOf(store);
  const drawing = drawingOf(store);
  const scale = store.view.peek()?.scale ?? 0;
  if (!drawing || !from || !to) {
    mapEditing.drop();
    return;
  }
  const before = mapEditing.isSent.peek() ? null : mapEditing.sketch.peek();
  const points = isFree(drawing) ? grown(before ?? [from], to, SPACING_PX * scale, isDone) : [from, to];
  mapEditing.isSent.value = false;
  mapEditing.sketch.value = points;
  if (isDone) finish(store, drawing, points, scale);
}

function grown(points: readonly Point[], to: Point, spacing: number, isLast: boolean): readonly Point[] {
  const last = points.at(-1) ?? to;
  const isFar = Math.hypot(to[0] - last[0], to[1] - last[1]) >= spacing;
  return points.length < MOST_POINTS && (isFar || (isLast && points.length > 1)) ? [...points, to] : points;
}

function finish(store: Store, drawing: Drawing, points: readonly Point[], scale: number): void {
  const command = commandOf(drawing, points, scale);
  if (!command) {
    mapEditingOf(store).drop();
    return;
  }
  mapEditingOf(store).isSent.value = true;
  mapEditingOf(store).corner.value = null;
  store.send(command);
}

/** A key of the focused map; true if the tool handled it. */
export function key(store: Store, pressed: string): boolean {
  const mapEditing = mapEditingOf(store);
  const drawing = drawingOf(store);
  const at = store.pinned.peek();
  if (pressed === "Enter" && drawing && at) {
    const from = mapEditing.corner.peek();
    if (from || drawing.tool === "brush") stroke(store, from ?? at, at, true);
    else {
      mapEditing.corner.value = at;
      mapEditing.sketch.value = [at, at];
    }
    return true;
  }
  if (pressed === "Escape" && (mapEditing.sketch.peek() || mapEditing.corner.peek())) {
    mapEditing.drop();
    return true;
  }
  if (pressed === "[" || pressed === "]") {
    const factor = pressed === "]" ? 1.25 : 0.8;
    mapEditing.width.value = Math.min(WIDEST_M, Math.max(0.01, rounded(mapEditing.width.peek() * factor)));
    return true;
  }
  return false;
}

export const WIDEST_M = 5;
