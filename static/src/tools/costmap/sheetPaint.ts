/** Painting the exploded view: the sheets, one of them before the others, and a cell that is marked on each. */

import { nameOfCost } from "../../grid/costs";
import type { Cell } from "../../grid/lattice";
import { costOfByte } from "../../render/map/costColours";
import type { MapPicture } from "../../render/map/mapPicture";
import type { pictureColours } from "../../render/picture/pictureColours";
import type { Point } from "../../wire/protocol";
import { COSTS } from "./palettes";
import type { Sheet } from "./sheetImage";
import { paintOrder, placeOn, type SheetPlan, transformOf } from "./sheetPlan";

/** How much the floor of a sheet hides of the sheets below it, and that of the one in front. */
const FLOOR = 0.72;
const FLOOR_IN_FRONT = 0.94;

type Colours = typeof pictureColours.value;

/** A sheet's costs, the image that keeps them painted, and whether its layer is switched on. */
interface SheetContent {
  readonly map: MapPicture | null;
  readonly image: Sheet;
  readonly isOn: boolean;
}

/** Paint the sheets from the bottom up; the sheet `front` is seen whole. */
export function paintSheets(
  ctx: CanvasRenderingContext2D,
  ratio: number,
  plan: SheetPlan,
  sheets: readonly SheetContent[],
  front: number | null,
  colours: Colours,
): void {
  const { row0, rows, col0, cols } = plan.window;
  for (const n of paintOrder(sheets.length, front)) {
    const { map, image: kept, isOn } = sheets[n] as SheetContent;
    const corner = plan.corners[n] as Point;
    const [a, b, c, d, e, f] = transformOf(plan, corner);
    ctx.setTransform(a * ratio, b * ratio, c * ratio, d * ratio, e * ratio, f * ratio);
    ctx.globalAlpha = n === front ? FLOOR_IN_FRONT : FLOOR;
    ctx.fillStyle = colours.floor;
    ctx.fillRect(col0, row0, cols, rows);
    ctx.globalAlpha = 1;
    const image = map && kept.of(map, COSTS, colours);
    if (image)
      for (let times = 0; times < 2; times++) ctx.drawImage(image, col0, row0, cols, rows, col0, row0, cols, rows); // twice: thin walls stay visible
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.beginPath();
    for (const [u, v] of [
      [col0, row0],
      [col0 + cols, row0],
      [col0 + cols, row0 + rows],
      [col0, row0 + rows],
    ] as const)
      ctx.lineTo(...placeOn(plan, corner, u, v));
    ctx.closePath();
    ctx.lineWidth = n === front ? 2 : 1;
    ctx.strokeStyle = n === front ? colours.outline : colours.prior;
    ctx.setLineDash(isOn ? [] : [5, 4]);
    ctx.stroke();
    ctx.setLineDash([]);
  }
}

/** Mark a cell on all sheets, and write its cost beside each. */
export function paintCell(
  ctx: CanvasRenderingContext2D,
  ratio: number,
  plan: SheetPlan,
  sheets: readonly SheetContent[],
  cell: Cell,
  colours: Colours,
): void {
  const { row0, rows, col0, cols } = plan.window;
  if (cell.row < row0 || cell.col < col0 || cell.row >= row0 + rows || cell.col >= col0 + cols) return;
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  const places = plan.corners.map((corner) => placeOn(plan, corner, cell.col + 0.5, cell.row + 0.5));
  const [bottom, top] = [places[0], places.at(-1)];
  if (!bottom || !top) return;
  ctx.strokeStyle = ctx.fillStyle = colours.outline;
  ctx.lineWidth = 1;
  ctx.setLineDash([3, 3]);
  ctx.beginPath();
  ctx.moveTo(...bottom);
  ctx.lineTo(...top);
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.font = getComputedStyle(ctx.canvas).font;
  ctx.textAlign = "right";
  places.forEach(([x, y], n) => {
    ctx.fillStyle = ctx.strokeStyle = colours.outline;
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.ellipse(x, y, 6, 3, 0, 0, 2 * Math.PI);
    ctx.stroke();
    const map = sheets[n]?.map;
    if (!map) return;
    const text = nameOfCost(costOfByte(map.cells.at(cell.row, cell.col)));
    const [right, low] = placeOn(plan, plan.corners[n] as Point, col0 + cols, row0);
    const at: Point = [right + 70, low - 4];
    ctx.lineWidth = 4;
    ctx.strokeStyle = colours.halo;
    ctx.strokeText(text, ...at);
    ctx.fillText(text, ...at);
  });
}
