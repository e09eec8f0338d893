/** The measurement over the map: its points, its lines and their lengths. */

import type { Brush } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import { labelFont } from "../../style/colour";
import { written } from "../../ui/numbers";
import type { Point } from "../../wire/protocol";
import type { PagePart } from "../part";
import { measuringOf } from "./measuring";
import { distanceOf } from "./model";
import { placeAt } from "./tool";

const POINT_PX = 4;
let font = "";

export function watchMeasuring(store: Store): void {
  const measuring = measuringOf(store);
  const { pointer, pinned } = store;
  if (measuring.tool.value === null) return;
  void [measuring.points.value, measuring.isDone.value, measuring.snaps.value, pointer.value, pinned.value];
}

export function paintMeasuring(store: Store, brush: Brush): void {
  const tool = measuringOf(store).tool.peek();
  if (tool === null) return;
  const { ctx, size, view, colours } = brush;
  const at = (point: Point): Point => toScreen(view, size, ...point);
  const measured = measuringOf(store).onMap.peek();
  const pointer = store.probe.peek();
  const next = pointer && !measuringOf(store).isDone.peek() ? placeAt(store, pointer) : null;
  const points = next ? [...measured, next] : measured;
  const isClosed = tool === "area" && points.length > 2;
  ctx.beginPath();
  for (const point of points) ctx.lineTo(...at(point));
  if (isClosed) {
    ctx.closePath();
    ctx.globalAlpha = 0.2;
    ctx.fillStyle = colours.beam;
    ctx.fill();
    ctx.globalAlpha = 1;
  }
  for (const [width, style] of [
    [5, colours.halo],
    [2, colours.beam],
  ] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = style;
    ctx.stroke();
  }
  for (const point of points) {
    const [x, y] = at(point);
    ctx.beginPath();
    ctx.arc(x, y, POINT_PX, 0, 2 * Math.PI);
    ctx.fillStyle = colours.halo;
    ctx.fill();
    ctx.lineWidth = 2;
    ctx.strokeStyle = colours.beam;
    ctx.stroke();
  }
  for (let i = isClosed ? 0 : 1; i < points.length; i++) {
    const [from, to] = [points.at(i - 1) as Point, points[i] as Point];
    paintLength(brush, at(from), at(to), `${written(distanceOf(from, to), 2)} m`);
  }
}

function paintLength({ ctx, colours }: Brush, [x0, y0]: Point, [x1, y1]: Point, text: string): void {
  font ||= labelFont();
  ctx.font = font;
  const width = ctx.measureText(text).width + 8;
  if (Math.hypot(x1 - x0, y1 - y0) < width) return;
  const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
  ctx.fillStyle = colours.halo;
  ctx.fillRect(x - width / 2, y - 10, width, 20);
  ctx.fillStyle = colours.outline;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillText(text, x, y);
}

export const PART: PagePart = {
  overlay: { watch: watchMeasuring, paint: paintMeasuring },
};
