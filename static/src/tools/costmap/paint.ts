/** Drawing of the costmap and the path in the pictures: costs over the belief, the path, the goal, painted zones. */

import { cellAt } from "../../grid/lattice";
import { costOfByte } from "../../render/map/costColours";
import type { Layer } from "../../render/map/renderer";
import type { Brush } from "../../render/picture/brush";
import { columnOf, type LayerContent, OVERLAYS } from "../../render/picture/overlays";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import type { BrushStroke, Point, Pose, Value } from "../../wire/protocol";
import { pathOf } from "../path/state";
import { COSTS_OVER, POTENTIAL_OVER, SPEED_OVER } from "./palettes";
import { costmapOf } from "./state";

const isAbsolute = (kind: Value | undefined): boolean => kind === "absolute";

/** The unit of the limits, and the limit for a mask value of 1. */
export const limitUnit = (kind: Value | undefined): { readonly unit: string; readonly step: number } =>
  isAbsolute(kind) ? { unit: "m/s", step: 0.01 } : { unit: "%", step: 1 };

/** The limit of a value of the mask in words. */
function limitText(value: number, kind: Value | undefined): string {
  const { unit, step } = limitUnit(kind);
  return `${isAbsolute(kind) ? (value * step).toFixed(2) : value} ${unit}`;
}

/** Name and style of the layer with the path. */
export const PLAN = "plan";
/** Name of the grid of speed limits. */
export const SPEED_LIMITS = "speed_filter";
const GOAL_PX = 9;

/** The grids drawn over the belief: costs or potential, and the speed limits. */
export function costsOver(store: Store): readonly Layer[] {
  const name = costmapOf(store).over.peek();
  const map = name === null ? null : store.layers.grid(name).map.peek();
  const limits = store.layers.grid(SPEED_LIMITS).map.peek();
  return [
    ...(map ? [{ map, palette: name === "costmap" ? COSTS_OVER : POTENTIAL_OVER, blends: true }] : []),
    ...(limits ? [{ map: limits, palette: SPEED_OVER, blends: true }] : []),
  ];
}

/** Read every signal that is painted here. */
export function watchNavigation(store: Store): void {
  const { layers } = store;
  const state = costmapOf(store);
  void [pathOf(store).path.value, state.costmap.value, state.stroke.value, pathOf(store).goalAt.value];
  void [state.asked.value, state.tool.value, layers.content(PLAN).value];
  void layers.grid(SPEED_LIMITS).version.value;
  const over = state.over.value;
  if (over) void layers.grid(over).version.value;
}

/** The path and the speed limits in a picture that does not show the layers. */
export function paintPathOf(store: Store, brush: Brush): void {
  for (const stroke of costmapOf(store).costmap.peek()?.keepout ?? [])
    if (limitOf(store, stroke) !== null) outlineStroke(brush, stroke);
  const content = store.layers.content(PLAN).peek();
  if (content) paintPlan(brush, content);
}

function paintPlan(brush: Brush, content: LayerContent): void {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  if (!xs || !ys || xs.length < 2) return;
  const { ctx, view, size, colours } = brush;
  const [x0, y0] = toScreen(view, size, 0, 0);
  ctx.beginPath();
  for (let i = 0; i < xs.length; i++)
    ctx.lineTo(x0 + (xs[i] as number) / view.scale, y0 - (ys[i] as number) / view.scale);
  ctx.lineJoin = ctx.lineCap = "round";
  for (const [width, colour] of [
    [6, colours.halo],
    [3, colours.robot],
  ] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.stroke();
  }
  ctx.lineJoin = "miter";
  ctx.lineCap = "butt";
}

OVERLAYS[PLAN] = paintPlan;

/** Paint the outline of the robot, the painted zones, the target point of the pursuit and the goal. */
export function paintNavigation(store: Store, brush: Brush): void {
  const state = costmapOf(store);
  const costmap = state.costmap.peek();
  if (!costmap?.is_on) return;
  if (state.tool.peek() === "keepout" || state.tool.peek() === "erase") {
    for (const stroke of costmap.keepout) if (!stroke.erases && stroke.speed == null) outlineStroke(brush, stroke);
  }
  for (const stroke of costmap.keepout) writeLimit(store, brush, stroke);
  const stroke = state.stroke.peek();
  if (stroke) outlineStroke(brush, stroke);
  const path = pathOf(store).path.peek();
  const frame = store.beliefFrame.peek();
  if (frame) paintOutline(brush, costmap.footprint, frame.pose);
  if (path?.carrot && frame) paintCarrot(brush, path.carrot, frame.pose);
  const goal = pathOf(store).goalAt.peek() ?? path?.goal;
  if (goal) paintGoal(brush, goal, pathOf(store).goalAt.peek() !== null, path?.length == null);
  const asked = state.asked.peek();
  if (asked && state.tool.peek() === "cost") paintAsked(brush, asked);
}

function outlineStroke({ ctx, view, size, colours }: Brush, { width, erases, points, speed }: BrushStroke): void {
  const places = points.map(([x, y]) => toScreen(view, size, x, y));
  const [first] = places;
  if (!first) return;
  ctx.beginPath();
  ctx.moveTo(...first);
  for (const place of places) ctx.lineTo(...place);
  ctx.lineCap = ctx.lineJoin = "round";
  ctx.lineWidth = width / view.scale;
  ctx.globalAlpha = 0.3;
  ctx.strokeStyle = erases ? colours.floor : speed == null ? colours.hit : colours.speedLimit;
  ctx.stroke();
  ctx.globalAlpha = 1;
  ctx.lineCap = "butt";
  ctx.lineJoin = "miter";
}

/** The limit that a stroke painted, if it still applies at the stroke's middle; null for none. */
function limitOf(store: Store, { points, speed }: BrushStroke): number | null {
  const limits = store.layers.grid(SPEED_LIMITS).map.peek();
  const place = middleOf(points);
  if (!limits || !place || speed == null) return null;
  const cell = cellAt(limits.geometry, place[0], place[1]);
  const { rows, cols } = limits.geometry;
  if (cell.row < 0 || cell.col < 0 || cell.row >= rows || cell.col >= cols) return null;
  return costOfByte(limits.cells.at(cell.row, cell.col)) === speed ? speed : null;
}

const middleOf = (points: readonly Point[]): Point | undefined => points[Math.floor(points.length / 2)];

/** Write the limit of a stroke in its middle. */
function writeLimit(store: Store, { ctx, view, size, colours }: Brush, stroke: BrushStroke): void {
  const speed = limitOf(store, stroke);
  const place = middleOf(stroke.points);
  if (speed === null || !place) return;
  const text = limitText(speed, costmapOf(store).values.values.peek().speed_limits);
  const [x, y] = toScreen(view, size, ...place);
  ctx.font = `600 13px ${getComputedStyle(ctx.canvas).fontFamily}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineWidth = 4;
  ctx.lineJoin = "round";
  ctx.strokeStyle = colours.halo;
  ctx.strokeText(text, x, y);
  ctx.fillStyle = colours.outline;
  ctx.fillText(text, x, y);
  ctx.textAlign = "start";
  ctx.textBaseline = "alphabetic";
  ctx.lineJoin = "miter";
}

/** The outline of the robot at a pose. */
function paintOutline({ ctx, view, size, colours }: Brush, corners: readonly Point[], [x, y, yaw]: Pose): void {
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  ctx.beginPath();
  for (const [cx, cy] of corners) ctx.lineTo(...toScreen(view, size, x + c * cx - s * cy, y + s * cx + c * cy));
  ctx.closePath();
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colours.outline;
  ctx.stroke();
}

/** The point ahead that the robot pursues, and the line to it. */
function paintCarrot({ ctx, view, size, colours }: Brush, carrot: Point, [x, y]: Pose): void {
  const [cx, cy] = toScreen(view, size, ...carrot);
  ctx.beginPath();
  ctx.moveTo(...toScreen(view, size, x, y));
  ctx.lineTo(cx, cy);
  ctx.setLineDash([3, 3]);
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colours.outline;
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.arc(cx, cy, 4.5, 0, 2 * Math.PI);
  ctx.fillStyle = colours.halo;
  ctx.fill();
  ctx.stroke();
}

/** The goal: a ring with a dot, crossed out if no path leads there. */
function paintGoal({ ctx, view, size, colours }: Brush, goal: Point, isHeld: boolean, isRefused: boolean): void {
  const [x, y] = toScreen(view, size, ...goal);
  const radius = isHeld ? 1.3 * GOAL_PX : GOAL_PX;
  ctx.beginPath();
  ctx.arc(x, y, radius + 2, 0, 2 * Math.PI);
  ctx.fillStyle = colours.halo;
  ctx.fill();
  const colour = isRefused ? colours.hit : colours.robot;
  ctx.lineWidth = 3;
  ctx.strokeStyle = ctx.fillStyle = colour;
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.beginPath();
  if (isRefused) {
    const d = 0.5 * radius;
    ctx.moveTo(x - d, y - d);
    ctx.lineTo(x + d, y + d);
    ctx.moveTo(x + d, y - d);
    ctx.lineTo(x - d, y + d);
    ctx.stroke();
  } else {
    ctx.arc(x, y, 0.4 * radius, 0, 2 * Math.PI);
    ctx.fill();
  }
}

function paintAsked({ ctx, view, size, colours }: Brush, asked: Point): void {
  const [x, y] = toScreen(view, size, ...asked);
  ctx.strokeStyle = colours.outline;
  ctx.lineWidth = 2;
  ctx.strokeRect(x - 5, y - 5, 10, 10);
}
