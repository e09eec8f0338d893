/** The drawing over an edited map: the sketch of the tool, the origin, and the map after rotation. */

import { centreOf, fromLattice } from "../../grid/lattice";
import { PALETTE_ROWS, type Palette } from "../../render/map/palettes";
import type { Layer } from "../../render/map/renderer";
import { type Brush, paintCell, paintCrosshair } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import { tokenRgb } from "../../style/colour";
import type { Geometry, Point } from "../../wire/protocol";
import { SPEED_LIMITS } from "../costmap/paint";
import { SPEED_OVER } from "../costmap/palettes";
import { mapEditingOf } from "./state";
import { drawingOf, isFree, shapeOf } from "./strokes";

const AXIS_PX = 46;
const HEAD_PX = 7;

/** Keepout zones: striped, so that they are not identified by colour alone; byte 0 means no zone. */
const KEEPOUT: Palette = {
  key: "keepout",
  colours: () => {
    const out = new Uint8Array(256 * 4 * PALETTE_ROWS);
    for (let row = 0; row < PALETTE_ROWS; row++) {
      const alpha = row % 2 === 0 ? 150 : 50;
      for (let byte = 1; byte < 256; byte++) out.set([...tokenRgb("--cost-inscribed"), alpha], 4 * (256 * row + byte));
    }
    return out;
  },
};

/** The layer of keepout zones. */
export const ZONES = "keepout";

/** The keepout zones and the speed limits, drawn over the map. */
export function zonesOver(store: Store): readonly Layer[] {
  const zones = store.layers.grid(ZONES).map.peek();
  const limits = store.layers.grid(SPEED_LIMITS).map.peek();
  return [
    ...(limits ? [{ map: limits, palette: SPEED_OVER, blends: true }] : []),
    ...(zones ? [{ map: zones, palette: KEEPOUT, blends: true }] : []),
  ];
}

/** Read every signal that is painted here. */
export function watchEditing(store: Store): void {
  const { tool, state, width, isFreehand, allows, sketch, isSent, corner, turn } = mapEditingOf(store);
  for (const signal of [tool, state, width, isFreehand, allows, sketch, isSent, corner, turn]) void signal.value;
  void [store.cell.value, store.pinned.value];
  for (const layer of [ZONES, SPEED_LIMITS]) void store.layers.grid(layer).version.value;
}

export function paintEditing(store: Store, brush: Brush): void {
  const mapEditing = mapEditingOf(store);
  const geometry = store.map.peek()?.geometry;
  if (geometry && mapEditing.turn.peek()) paintTurned(brush, geometry, mapEditing.turn.peek() as number);
  paintOrigin(brush);
  const drawing = drawingOf(store);
  const points = sketchOf(store);
  if (drawing && points) {
    const shape = shapeOf(drawing, points);
    if (drawing.tool === "origin") paintArrow(brush, points);
    else if (drawing.tool === "brush" || drawing.tool === "line") paintWide(brush, shape, drawing.width, drawing.state);
    else if (drawing.tool === "straighten") paintLine(brush, shape);
    else paintArea(brush, shape, drawing.tool === "crop", isFree(drawing));
  } else if (drawing?.tool === "brush") paintTip(store, brush, drawing.width);
  const cell = store.pinned.peek() ? store.cell.peek() : null;
  if (cell && geometry) {
    paintCell(brush, geometry, cell.row, cell.col, brush.colours.outline);
    paintCrosshair(brush, centreOf(geometry, cell));
  }
}

/** The current drawing; from the corner set by the keyboard to the cursor. */
function sketchOf(store: Store): readonly Point[] | null {
  const { corner, sketch } = mapEditingOf(store);
  const from = corner.peek();
  const to = store.probe.peek();
  return from && to ? [from, to] : sketch.peek();
}

function trace({ ctx, view, size }: Brush, points: readonly Point[]): void {
  ctx.beginPath();
  for (const [i, [x, y]] of points.entries()) {
    if (i === 0) ctx.moveTo(...toScreen(view, size, x, y));
    else ctx.lineTo(...toScreen(view, size, x, y));
  }
}

function paintWide(brush: Brush, points: readonly Point[], width: number, state: string): void {
  const { ctx, view, colours } = brush;
  const shown = points.length === 1 ? [...points, ...points] : points;
  trace(brush, shown);
  ctx.lineCap = ctx.lineJoin = "round";
  ctx.lineWidth = Math.max(2, width / view.scale);
  ctx.globalAlpha = 0.7;
  ctx.strokeStyle = state === "occupied" ? colours.hit : state === "free" ? colours.miss : colours.outline;
  ctx.stroke();
  ctx.globalAlpha = 1;
  ctx.lineCap = "butt";
  ctx.lineJoin = "miter";
}

/** The brush under the pointer. */
function paintTip(store: Store, { ctx, view, size, colours }: Brush, width: number): void {
  const at = store.probe.peek();
  if (!at) return;
  ctx.beginPath();
  ctx.arc(...toScreen(view, size, at[0], at[1]), Math.max(2, width / view.scale / 2), 0, 2 * Math.PI);
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colours.outline;
  ctx.stroke();
}

function twice(brush: Brush, dash: number[] = []): void {
  const { ctx, colours } = brush;
  for (const [width, colour] of [
    [4, colours.halo],
    [1.5, colours.outline],
  ] as const) {
    ctx.setLineDash(width === 4 ? [] : dash);
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.stroke();
  }
  ctx.setLineDash([]);
}

function paintLine(brush: Brush, points: readonly Point[]): void {
  trace(brush, points);
  twice(brush);
}

/** An area, or the part that a crop keeps; the rest is dimmed. */
function paintArea(brush: Brush, points: readonly Point[], isCrop: boolean, isOpen: boolean): void {
  const { ctx, size, colours } = brush;
  trace(brush, points);
  ctx.closePath();
  ctx.globalAlpha = isCrop ? 0.5 : 0.35;
  ctx.fillStyle = isCrop ? colours.halo : colours.robot;
  if (isCrop) ctx.rect(0, 0, size.width, size.height);
  ctx.fill("evenodd");
  ctx.globalAlpha = 1;
  trace(brush, points);
  if (!isOpen) ctx.closePath();
  twice(brush);
}

/** The axes of the map's coordinates: x and y at (0, 0). */
function paintOrigin(brush: Brush): void {
  const { view, size, ctx, colours } = brush;
  const [x, y] = toScreen(view, size, 0, 0);
  for (const [dx, dy, name] of [
    [AXIS_PX, 0, "x"],
    [0, -AXIS_PX, "y"],
  ] as const) {
    paintHead(brush, [x, y], [x + dx, y + dy]);
    ctx.font = "600 12px system-ui, sans-serif";
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 3;
    ctx.strokeStyle = colours.halo;
    ctx.fillStyle = colours.robot;
    const at = [x + dx * 1.25, y + dy * 1.25] as const;
    ctx.strokeText(name, ...at);
    ctx.fillText(name, ...at);
  }
}

/** The new origin, and the direction of its x axis. */
function paintArrow(brush: Brush, points: readonly Point[]): void {
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last) return;
  const from = toScreen(brush.view, brush.size, ...first);
  const to = toScreen(brush.view, brush.size, ...last);
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const [dx, dy] = length < 4 ? [1, 0] : [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
  paintHead(brush, from, [from[0] + AXIS_PX * dx, from[1] + AXIS_PX * dy]);
  paintHead(brush, from, [from[0] + AXIS_PX * dy, from[1] - AXIS_PX * dx]);
}

/** An arrow between two places on the screen. */
function paintHead({ ctx, colours }: Brush, [x0, y0]: Point, [x1, y1]: Point): void {
  const angle = Math.atan2(y1 - y0, x1 - x0);
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(x1, y1);
  for (const side of [-0.5, 0.5]) {
    ctx.moveTo(x1, y1);
    ctx.lineTo(x1 - HEAD_PX * Math.cos(angle + side), y1 - HEAD_PX * Math.sin(angle + side));
  }
  for (const [width, colour] of [
    [5, colours.halo],
    [2.5, colours.robot],
  ] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.stroke();
  }
}

/** The frame of the map after a turn about the origin. */
function paintTurned(brush: Brush, geometry: Geometry, angle: number): void {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const corners = [
    [0, 0],
    [geometry.cols, 0],
    [geometry.cols, geometry.rows],
    [0, geometry.rows],
    [0, 0],
  ].map(([u, v]): Point => {
    const [x, y] = fromLattice(geometry, u as number, v as number);
    return [c * x - s * y, s * x + c * y];
  });
  trace(brush, corners);
  twice(brush, [6, 5]);
}
