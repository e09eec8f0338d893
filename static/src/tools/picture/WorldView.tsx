/** The true world: the obstacles, the robot and its beams. A click moves the robot. */

import { beamAt } from "../../grid/beams";
import { centreOf } from "../../grid/lattice";
import { createSurface, resizeCanvas, type Surface } from "../../render/map/surface";
import {
  type Brush,
  brushOn,
  paintBeam,
  paintBeams,
  paintCell,
  paintCrosshair,
  paintRipple,
  paintRobot,
  tracePolygon,
} from "../../render/picture/brush";
import { pictureColours } from "../../render/picture/pictureColours";
import { type ScanFade, scanFade } from "../../render/picture/scanFade";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import { reducedMotion } from "../../ui/browser/media";
import { paintNavigation, paintPathOf, watchNavigation } from "../costmap/paint";
import { paintEditing } from "../editing/paint";
import { paintSteps } from "../steps/paint";
import { paintWhy } from "../why/paint";
import { act } from "./keyboard";
import { LinkedPicture } from "./LinkedPicture";

/** The floor plan: painted only when the view, the world or the theme changes. */
function paintPlan(store: Store, canvas: HTMLCanvasElement, size: { width: number; height: number }, ratio: number) {
  const view = store.view.peek();
  const world = store.world.peek();
  if (!view) return;
  const colours = pictureColours.peek();
  const brush = brushOn(canvas, size, ratio, view, colours);
  if (!brush) return;
  const { ctx } = brush;
  ctx.fillStyle = colours.outside;
  ctx.fillRect(0, 0, size.width, size.height);
  if (!world) return;
  const [x0, y0, x1, y1] = world.bounds;
  ctx.beginPath();
  tracePolygon(brush, [
    [x0, y0],
    [x1, y0],
    [x1, y1],
    [x0, y1],
  ]);
  ctx.fillStyle = colours.floor;
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.strokeStyle = colours.solid;
  ctx.stroke();
  ctx.beginPath();
  for (const polygon of world.polygons) tracePolygon(brush, polygon);
  ctx.fillStyle = colours.solid;
  ctx.fill("nonzero");
  // Solids with their own heights, which beams may pass above or below.
  ctx.beginPath();
  for (const block of world.blocks ?? []) tracePolygon(brush, block.outline);
  ctx.setLineDash([5, 3]);
  ctx.lineWidth = 1.5;
  ctx.stroke();
  ctx.setLineDash([]);
}

export function WorldView({ store }: { readonly store: Store }) {
  return (
    <LinkedPicture
      store={store}
      label="The true world. Arrow keys or W A S D drive the robot; Shift and arrows move the cell cursor, Enter moves the robot there or uses the selected editing tool, question mark explains the value of its cell; plus and minus zoom, 0 shows everything."
      draws
      onTap={(point) => act(store, point)}
      setUp={(canvas, invalidate) => {
        const plan = document.createElement("canvas");
        const surface = surfaceFor(canvas, invalidate);
        const fade: ScanFade = scanFade();
        let painted: readonly unknown[] = [];
        return {
          watch: () => {
            void store.world.value;
            void store.frame.value;
            void store.probe.value;
            void store.pointer.value;
            void store.inspectedBeam.value;
            void store.teleported.value;
            void store.draggedTo.value;
            void store.explainedCell.value;
            void store.editing.tool.value;
            void store.editing.sketch.value;
            void store.editing.corner.value;
            void store.faults.value;
            void store.stepping.value;
            void store.selectedContribution.value;
            watchNavigation(store);
            void pictureColours.value;
          },
          paint: (size, ratio, now) => {
            const view = store.view.peek();
            if (!view || !surface) return false;
            const basis = [view, store.world.peek(), pictureColours.peek(), size.width, size.height, ratio];
            if (basis.some((value, i) => value !== painted[i])) {
              painted = basis;
              resizeCanvas(plan, canvas.width, canvas.height);
              paintPlan(store, plan, size, ratio);
            }
            let moves = false;
            surface((painting) => {
              const brush = brushOn(painting, size, ratio, view, pictureColours.peek());
              if (!brush) return;
              brush.ctx.drawImage(plan, 0, 0, size.width, size.height);
              moves = paintOverlay(store, brush, fade, now);
            });
            return moves;
          },
        };
      }}
    />
  );
}

function surfaceFor(canvas: HTMLCanvasElement, invalidate: () => void): Surface | null {
  try {
    return createSurface(canvas, invalidate);
  } catch {
    return null; // the map view shows the error
  }
}

function paintOverlay(store: Store, brush: Brush, fade: ScanFade, now: number): boolean {
  const frame = store.frame.peek();
  if (!frame) return false;
  const stepping = store.stepping.peek();
  if (stepping) {
    paintRobot(brush, frame.pose, false);
    paintSteps(store, brush, false);
    return false;
  }
  const strength = fade(frame.index, now);
  const from = frame.scan_pose;
  paintBeams(brush, from, frame, frame.range_max, strength);
  const inspected = store.inspectedBeam.peek();
  const beam = inspected && beamAt(frame, inspected.index); // the true beam, whatever faults the map has
  if (beam && store.probe.peek()) paintBeam(brush, from, beam, frame.range_max);
  paintWhy(store, brush);
  paintEditing(store, brush);
  const map = store.map.peek();
  const cell = store.cell.peek();
  if (cell && map) {
    paintCell(brush, map.geometry, cell.row, cell.col, brush.colours.outline);
    paintCrosshair(brush, centreOf(map.geometry, cell));
  }
  paintPathOf(store, brush);
  paintNavigation(store, brush);
  const draggedTo = store.draggedTo.peek();
  paintRobot(brush, frame.pose, draggedTo !== null);
  if (draggedTo) paintDragPointer(brush.ctx, toScreen(brush.view, brush.size, ...draggedTo), brush.colours.robot);
  const sent = store.teleported.peek();
  const ripples = sent !== null && !reducedMotion.peek() && paintRipple(brush, sent.point, now - sent.at);
  return ripples || strength > 0;
}

/** Mark the pointer while it drags the robot, because the robot itself stays out of walls. */
function paintDragPointer(ctx: CanvasRenderingContext2D, [x, y]: readonly [number, number], style: string): void {
  ctx.beginPath();
  ctx.arc(x, y, 15, 0, 2 * Math.PI);
  ctx.setLineDash([4, 4]);
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = style;
  ctx.stroke();
  ctx.setLineDash([]);
}
