/**
 * Painting functions of the pictures: the robot, its beams, the pointer. Input in world metres, output in canvas
 * pixels.
 */

import { along, type Beam, bearingOf } from "../../grid/beams";
import { fromLattice } from "../../grid/lattice";
import { ROBOT_RADIUS } from "../../wire/constants";
import type { Frame, Geometry, Point, Pose } from "../../wire/protocol";
import { type Size, toScreen, type View } from "../view";
import type { PictureColours } from "./pictureColours";

const SMALLEST_ROBOT_PX = 8;
const NEAR_PX = 40;
const RIPPLE_MS = 700;

export interface Brush {
  readonly ctx: CanvasRenderingContext2D;
  readonly size: Size;
  readonly view: View;
  readonly colours: PictureColours;
}

/** A brush whose unit is one CSS pixel; null if the browser gives no context. The canvas is not cleared. */
export function brushOn(
  canvas: HTMLCanvasElement,
  size: Size,
  ratio: number,
  view: View,
  colours: PictureColours,
): Brush | null {
  // Read frequently: every painted canvas is copied from main memory to a texture.
  const ctx = canvas.getContext("2d", { willReadFrequently: true });
  if (!ctx) return null;
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { ctx, size, view, colours };
}

const place = ({ view, size }: Brush, [x, y]: Point): Point => toScreen(view, size, x, y);

/** Radius of the drawn robot in CSS pixels, with a minimum so that it can be seen and dragged. */
export const robotPx = (view: View): number => Math.max(SMALLEST_ROBOT_PX, ROBOT_RADIUS / view.scale);

/** The endpoints of all beams on the screen as x, y pairs; NaN for beams without a return or beyond `rangeMax`. */
function endpoints(brush: Brush, from: Pose, frame: Frame, rangeMax: number): Float32Array {
  const ends = new Float32Array(2 * frame.ranges.length);
  for (let i = 0; i < frame.ranges.length; i++) {
    const range = frame.ranges[i] ?? null;
    if (range === null || range > rangeMax) {
      ends[2 * i] = ends[2 * i + 1] = Number.NaN;
      continue;
    }
    const [x, y] = place(brush, along(from, bearingOf(frame, i), range));
    ends[2 * i] = x;
    ends[2 * i + 1] = y;
  }
  return ends;
}

/**
 * All beams of a scan: a line for each, a dot of `dotPx` at each reading. `strength` 0 … 1 fades them after the scan.
 */
export function paintBeams(
  brush: Brush,
  from: Pose,
  frame: Frame,
  rangeMax: number,
  strength: number,
  dotPx = 2.5,
): void {
  const { ctx, colours } = brush;
  const ends = endpoints(brush, from, frame, rangeMax);
  const [sx, sy] = place(brush, [from[0], from[1]]);
  // Of a dense scan only every n-th line is drawn; every reading has its dot.
  const every = Math.max(1, Math.round(frame.ranges.length / 180));
  if (frame.beam_width) paintCones(brush, from, frame, ends, frame.beam_width, strength);
  ctx.beginPath();
  for (let i = 0; i < ends.length; i += 2 * every) {
    const x = ends[i] as number;
    if (Number.isNaN(x)) continue;
    ctx.moveTo(sx, sy);
    ctx.lineTo(x, ends[i + 1] as number);
  }
  ctx.globalAlpha = 0.16 + 0.3 * strength;
  ctx.strokeStyle = colours.beamFill;
  ctx.lineWidth = 1;
  ctx.stroke();
  ctx.globalAlpha = 0.55 + 0.45 * strength;
  ctx.fillStyle = colours.beam;
  const dot = dotPx + strength;
  for (let i = 0; i < ends.length; i += 2) {
    const x = ends[i] as number;
    if (!Number.isNaN(x)) ctx.fillRect(x - dot / 2, (ends[i + 1] as number) - dot / 2, dot, dot);
  }
  ctx.globalAlpha = 1;
}

/** The cones of sonars: the nearest surface is somewhere on each arc. */
function paintCones(brush: Brush, from: Pose, frame: Frame, ends: Float32Array, width: number, strength: number): void {
  const { ctx, view, colours } = brush;
  const [sx, sy] = place(brush, [from[0], from[1]]);
  ctx.fillStyle = colours.beamFill;
  ctx.strokeStyle = colours.beam;
  ctx.lineWidth = 2;
  for (let i = 0; i < frame.ranges.length; i++) {
    if (Number.isNaN(ends[2 * i] as number)) continue;
    // On the screen y points down, so angles are clockwise.
    const axis = -(from[2] + bearingOf(frame, i));
    const radius = (frame.ranges[i] as number) / view.scale;
    ctx.beginPath();
    ctx.arc(sx, sy, radius, axis - width / 2, axis + width / 2);
    ctx.globalAlpha = 0.5 + 0.4 * strength;
    ctx.stroke();
    ctx.lineTo(sx, sy);
    ctx.globalAlpha = 0.1 + 0.1 * strength;
    ctx.fill();
  }
}

/** The inspected beam. */
export function paintBeam(brush: Brush, from: Pose, beam: Beam, rangeMax: number): void {
  const { ctx, colours } = brush;
  const returned = beam.range !== null && beam.range <= rangeMax;
  const [sx, sy] = place(brush, [from[0], from[1]]);
  const [x, y] = place(brush, along(from, beam.bearing, returned ? (beam.range as number) : rangeMax));
  ctx.beginPath();
  ctx.moveTo(sx, sy);
  ctx.lineTo(x, y);
  ctx.setLineDash(returned ? [] : [5, 5]);
  ctx.lineWidth = 2;
  ctx.strokeStyle = colours.beam;
  ctx.stroke();
  ctx.setLineDash([]);
  if (!returned) return;
  ctx.beginPath();
  ctx.arc(x, y, 4, 0, 2 * Math.PI);
  ctx.fillStyle = colours.beam;
  ctx.fill();
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colours.halo;
  ctx.stroke();
}

export function paintRobot(brush: Brush, pose: Pose, isHeld: boolean): void {
  const { ctx, colours } = brush;
  const [x, y] = place(brush, [pose[0], pose[1]]);
  const radius = robotPx(brush.view) * (isHeld ? 1.2 : 1);
  if (radius <= NEAR_PX) {
    ctx.beginPath();
    ctx.arc(x, y, radius + 2, 0, 2 * Math.PI);
    ctx.fillStyle = colours.halo;
    ctx.fill();
  }
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  // When zoomed in it would hide the cells under it.
  ctx.globalAlpha = radius > NEAR_PX ? 0.3 : 1;
  ctx.fillStyle = colours.robotFill;
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.lineWidth = 2;
  ctx.strokeStyle = colours.robot;
  ctx.stroke();
  // The heading: a wedge from the centre to the rim. Screen y points down.
  const c = Math.cos(pose[2]);
  const s = -Math.sin(pose[2]);
  ctx.beginPath();
  ctx.moveTo(x + radius * 0.95 * c, y + radius * 0.95 * s);
  ctx.lineTo(x - radius * (0.45 * c - 0.5 * s), y - radius * (0.45 * s + 0.5 * c));
  ctx.lineTo(x - radius * (0.45 * c + 0.5 * s), y - radius * (0.45 * s - 0.5 * c));
  ctx.closePath();
  ctx.globalAlpha = radius > NEAR_PX ? 0.4 : 1;
  ctx.fillStyle = colours.halo;
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.lineWidth = 1;
  ctx.stroke();
}

/** A crosshair at the inspected point, which is shown in all pictures. */
export function paintCrosshair(brush: Brush, point: Point): void {
  const { ctx, colours } = brush;
  const [x, y] = place(brush, point);
  for (const [width, style] of [
    [3, colours.halo],
    [1.25, colours.outline],
  ] as const) {
    ctx.beginPath();
    for (const [dx, dy] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ] as const) {
      ctx.moveTo(x + 5 * dx, y + 5 * dy);
      ctx.lineTo(x + 12 * dx, y + 12 * dy);
    }
    ctx.lineWidth = width;
    ctx.strokeStyle = style;
    ctx.stroke();
  }
}

/** Paint the outline of a polygon, with a halo. */
export function paintOutline(brush: Brush, corners: readonly Point[], style: string): void {
  const { ctx, colours } = brush;
  ctx.beginPath();
  for (const corner of corners) ctx.lineTo(...place(brush, corner));
  ctx.closePath();
  ctx.lineWidth = 4;
  ctx.strokeStyle = colours.halo;
  ctx.stroke();
  ctx.lineWidth = 2;
  ctx.strokeStyle = style;
  ctx.stroke();
}

/** The outline of a cell. For cells of a few pixels it is larger than the cell, so that it can be seen. */
export function paintCell(brush: Brush, geometry: Geometry, row: number, col: number, style: string): void {
  const grow = Math.max(0, (6 * brush.view.scale) / geometry.resolution - 1) / 2;
  const corners = [
    [col - grow, row - grow],
    [col + 1 + grow, row - grow],
    [col + 1 + grow, row + 1 + grow],
    [col - grow, row + 1 + grow],
  ] as const;
  paintOutline(
    brush,
    corners.map(([u, v]) => fromLattice(geometry, u, v)),
    style,
  );
}

/** Rings that spread from the point to which the robot was moved; returns false when the animation is over. */
export function paintRipple(brush: Brush, point: Point, age: number): boolean {
  if (age < 0 || age >= RIPPLE_MS) return false;
  const { ctx, colours } = brush;
  const [x, y] = place(brush, point);
  const t = age / RIPPLE_MS;
  ctx.lineWidth = 2.5;
  ctx.strokeStyle = colours.robot;
  for (const lag of [0, 0.25]) {
    const u = t - lag;
    if (u <= 0) continue;
    ctx.globalAlpha = (1 - t) ** 1.5;
    ctx.beginPath();
    ctx.arc(x, y, 6 + 46 * Math.sqrt(u), 0, 2 * Math.PI);
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
  return true;
}

/** A closed path of world points. */
export function tracePolygon(brush: Brush, points: readonly Point[]): void {
  let first = true;
  for (const point of points) {
    const [x, y] = place(brush, point);
    if (first) brush.ctx.moveTo(x, y);
    else brush.ctx.lineTo(x, y);
    first = false;
  }
  brush.ctx.closePath();
}

/**
 * The path of a log's robot: solid up to pose `done`, faint beyond. After a change of the sensor the last frame may
 * still count more poses than the new path has.
 */
export function paintPath(brush: Brush, poses: readonly Point[], done: number): void {
  const { ctx, colours } = brush;
  const near = 1.5 * brush.view.scale;
  for (const [from, to, alpha] of [
    [Math.max(0, done - 1), poses.length, 0.25],
    [0, Math.min(done, poses.length), 0.8],
  ] as const) {
    ctx.beginPath();
    let last: Point = [Number.NaN, Number.NaN];
    for (let i = from; i < to; i++) {
      const point = poses[i] as Point;
      if (Math.abs(point[0] - last[0]) < near && Math.abs(point[1] - last[1]) < near && i < to - 1) continue;
      last = point;
      ctx.lineTo(...place(brush, point));
    }
    ctx.globalAlpha = alpha;
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = colours.trail;
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}
