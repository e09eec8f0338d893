/** Paints costs, a potential and paths over the map of the stage. */

import { byteOfCost, costColours, potentialColours } from "../../render/map/costColours";
import { tokenRgb } from "../../style/colour";
import type { Point } from "../../wire/protocol";
import type { Projection } from "../stage/camera";
import { paintCells } from "../stage/paintCells";
import type { Costs } from "./costmap";
import type { Search } from "./planner";
import { GEOMETRY } from "./world";

/** RGBA of costs, cell by cell: laid over a map, or alone on a sheet. */
export function coloursOf(costs: Costs, isOver: boolean): Uint8ClampedArray<ArrayBuffer> {
  const row = costColours(isOver);
  const out = new Uint8ClampedArray(4 * costs.length);
  costs.forEach((cost, i) => {
    const byte = 4 * byteOfCost(cost);
    out.set(row.subarray(byte, byte + 4), 4 * i);
  });
  return out;
}

export const paintCosts = (context: CanvasRenderingContext2D, at: Projection, costs: Costs): void =>
  paintCells(context, at, GEOMETRY, coloursOf(costs, true));

/** The potential of the cells that the first part of a search has expanded, in bands. */
export function paintPotential(
  context: CanvasRenderingContext2D,
  at: Projection,
  { potential, order }: Search,
  share: number,
): void {
  const row = potentialColours();
  const out = new Uint8ClampedArray(4 * potential.length);
  const most = order.reduce((a, i) => Math.max(a, Number.isFinite(potential[i]) ? (potential[i] ?? 0) : 0), 1);
  for (const i of order.slice(0, Math.ceil(share * order.length))) {
    const cost = potential[i] ?? Number.POSITIVE_INFINITY;
    if (!Number.isFinite(cost)) continue;
    const byte = 4 * (1 + Math.round((254 * cost) / most));
    out.set(row.subarray(byte, byte + 4), 4 * i);
  }
  paintCells(context, at, GEOMETRY, out);
}

/** A path with a light border, dashed where it is only compared with. */
export function paintPath(
  context: CanvasRenderingContext2D,
  at: Projection,
  path: readonly Point[],
  isOther = false,
): void {
  const css = (token: `--${string}`): string => `rgb(${tokenRgb(token).join(" ")})`;
  context.beginPath();
  for (const [x, y] of path) context.lineTo(at.x(x), at.y(y));
  context.lineJoin = context.lineCap = "round";
  context.setLineDash(isOther ? [3, 7] : []);
  for (const [width, colour] of [
    [isOther ? 4 : 7, css("--surface")],
    [isOther ? 2 : 3.5, css("--robot")],
  ] as const) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.stroke();
  }
  context.setLineDash([]);
}
