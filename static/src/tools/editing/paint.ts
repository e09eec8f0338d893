/** The edit in progress, drawn over the world; and the faces from which no beam returns. */

import { type Brush, tracePolygon } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { outline } from "./shapes";
import { underEraser } from "./strokes";

export function paintEditing(store: Store, brush: Brush): void {
  const { ctx, colours } = brush;
  const { sketch, corner } = store.editing;
  const world = store.world.peek();
  if (store.faults.peek()?.specular === true && world) paintPolished(brush, world.polished);
  const doomed = underEraser(store, store.probe.peek());
  if (doomed !== null) {
    ctx.beginPath();
    tracePolygon(brush, world?.polygons[doomed] ?? []);
    ctx.fillStyle = colours.hit;
    ctx.fill();
  }
  const drawing = sketch.peek();
  if (drawing) {
    ctx.beginPath();
    tracePolygon(brush, outline(drawing));
    ctx.globalAlpha = 0.6;
    ctx.fillStyle = colours.robot;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = colours.robot;
    ctx.stroke();
  }
  const begun = corner.peek();
  if (begun) paintCorner(brush, begun);
}

function paintPolished(brush: Brush, faces: readonly (readonly [number, number, number, number])[]): void {
  const { ctx, colours, view, size } = brush;
  ctx.beginPath();
  for (const [ax, ay, bx, by] of faces) {
    ctx.moveTo(...toScreen(view, size, ax, ay));
    ctx.lineTo(...toScreen(view, size, bx, by));
  }
  ctx.lineWidth = 3;
  ctx.strokeStyle = colours.miss;
  ctx.stroke();
}

function paintCorner({ ctx, colours, view, size }: Brush, point: Point): void {
  const [x, y] = toScreen(view, size, ...point);
  ctx.beginPath();
  ctx.arc(x, y, 5, 0, 2 * Math.PI);
  ctx.fillStyle = colours.robot;
  ctx.fill();
}
