/** The layers of the costmap in an exploded view. The same cell is marked on each sheet, with its costs. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { nameOfCost } from "../../grid/costs";
import { type Cell, cellAt, centreOf } from "../../grid/lattice";
import { costOfByte } from "../../render/map/costColours";
import type { MapPicture } from "../../render/map/mapPicture";
import type { Palette } from "../../render/map/palettes";
import { pictureColours } from "../../render/picture/pictureColours";
import type { Store } from "../../store/store";
import { reducedMotion } from "../../ui/browser/media";
import { useWidth, zoomOf } from "../../ui/browser/useSize";
import { Slider } from "../../ui/Slider";
import { type Geometry, type Point, TILE } from "../../wire/protocol";
import { COSTS } from "./palettes";
import {
  cellOn,
  draggedGaps,
  LEAST_GAP,
  paintOrder,
  placeOn,
  type SheetPlan,
  sheetPlan,
  transformOf,
  type Window,
} from "./sheetPlan";
import { costmapOf } from "./state";
import { LAYER_NAMES } from "./WhyCost";

/** Opacity of a sheet's floor over the sheets below it, and that of the one in front. */
const FLOOR = 0.72;
const FLOOR_IN_FRONT = 0.94;

type Colours = typeof pictureColours.value;

/** A sheet's costs, the image in which they are cached, and whether its layer is switched on. */
interface SheetContent {
  readonly map: MapPicture | null;
  readonly image: Sheet;
  readonly isOn: boolean;
}

/** Paint the sheets from the bottom up; the sheet `front` is completely visible. */
function paintSheets(
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

/** Mark a cell on all sheets, and write its cost next to each. */
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

/** The sheets from the bottom up: the layers, and the total costs. */
const SHEETS = [
  "static_layer",
  "obstacle_layer",
  "dynamic_layer",
  "terrain_layer",
  "keepout_filter",
  "inflation_layer",
  "costmap",
];
const TERRAIN = "terrain_layer";
const HEIGHT = 350;
const ROOM = 265;
const FIRST_GAP = 50;
const OPENING_MS = 500;
const SLOP = 4;

/** The cells of a world, with a margin. */
function windowOf(store: Store, geometry: Geometry): Window {
  const bounds = store.world.peek()?.bounds;
  if (!bounds) return { row0: 0, rows: geometry.rows, col0: 0, cols: geometry.cols };
  const low = cellAt(geometry, bounds[0], bounds[1]);
  const high = cellAt(geometry, bounds[2], bounds[3]);
  const [row0, col0] = [Math.max(0, low.row), Math.max(0, low.col)];
  return { row0, col0, rows: Math.min(geometry.rows, high.row) - row0, cols: Math.min(geometry.cols, high.col) - col0 };
}

/** The sheets of the session's layers; that of a terrain exists only with the terrain. */
export function Sheets({ store }: { readonly store: Store }) {
  const hasTerrain = store.layers.infos.value.some(({ name }) => name === TERRAIN);
  const names = hasTerrain ? SHEETS : SHEETS.filter((name) => name !== TERRAIN);
  return <Stack key={names.length} store={store} names={names} />;
}

function Stack({ store, names }: { readonly store: Store; readonly names: readonly string[] }) {
  const { layers } = store;
  const state = costmapOf(store);
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const width = useWidth(box, 400).value;
  const first = Math.min(FIRST_GAP, Math.floor(ROOM / (names.length - 1)));
  const gaps = useSignal<readonly number[]>(names.slice(1).map(() => (reducedMotion.peek() ? first : LEAST_GAP)));
  const images = useRef<readonly Sheet[]>([]);
  if (images.current.length === 0) images.current = names.map(() => new Sheet());
  const held = useRef<{ sheet: number; y: number; gaps: readonly number[]; moved: boolean } | null>(null);
  const front = useSignal<number | null>(null);
  const isDragged = useSignal(false);

  useEffect(() => {
    const ends = names.map((name) => layers.subscribe(name));
    return () => {
      for (const end of ends) end();
    };
  }, [store]);
  useEffect(() => {
    if (reducedMotion.peek()) return;
    const began = performance.now();
    let frame = requestAnimationFrame(function open(now) {
      const share = Math.min(1, (now - began) / OPENING_MS);
      const gap = LEAST_GAP + (first - LEAST_GAP) * (1 - (1 - share) ** 3);
      gaps.value = gaps.peek().map(() => gap);
      if (share < 1) frame = requestAnimationFrame(open);
    });
    return () => cancelAnimationFrame(frame);
  }, [store]);

  const maps = names.map((name) => layers.grid(name));
  for (const map of maps) void map.version.value;
  const shown = maps.map((map) => map.map.value);
  const master = shown.at(-1) ?? null;
  const geometry = master?.geometry ?? null;
  const plan = geometry && sheetPlan(windowOf(store, geometry), width, HEIGHT, gaps.value);
  const probe = store.probe.value;
  const cell = geometry && probe ? cellAt(geometry, probe[0], probe[1]) : null;
  const colours = pictureColours.value;
  const values = state.values.values.value;
  const isOn = (name: string): boolean => values[name] !== false;
  const inFront = front.value;

  useEffect(() => {
    const element = canvas.current;
    if (!element || !plan) return;
    const ratio = devicePixelRatio;
    if (element.width !== width * ratio) element.width = width * ratio;
    if (element.height !== HEIGHT * ratio) element.height = HEIGHT * ratio;
    const ctx = element.getContext("2d");
    if (!ctx) return;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, element.width, element.height);
    const sheets = images.current.map((image, n) => ({
      image,
      map: shown[n] ?? null,
      isOn: isOn(names[n] as string),
    }));
    paintSheets(ctx, ratio, plan, sheets, inFront, colours);
    if (cell) paintCell(ctx, ratio, plan, sheets, cell, colours);
  });

  const inPicture = (event: PointerEvent): Point => {
    const at = event.currentTarget as HTMLElement;
    const rect = at.getBoundingClientRect();
    const zoom = zoomOf(at);
    return [(event.clientX - rect.left) / zoom, (event.clientY - rect.top) / zoom];
  };
  const point = (cell: Cell | undefined): Point | null => (geometry && cell ? centreOf(geometry, cell) : null);

  return (
    <div class="sheets" ref={box}>
      <div class="sheets-picture" style={{ height: `${HEIGHT}px` }}>
        <canvas
          ref={canvas}
          class={isDragged.value ? "dragged" : undefined}
          role="img"
          aria-label="The layers of the costmap as sheets above each other; the cell under the pointer is marked on each"
          onPointerDown={(event) => {
            const hit = plan && cellOn(plan, ...inPicture(event));
            if (event.button !== 0 || !hit) return;
            held.current = { sheet: hit.sheet, y: event.clientY, gaps: gaps.peek(), moved: false };
            front.value = hit.sheet;
            event.currentTarget.setPointerCapture(event.pointerId);
          }}
          onPointerMove={(event) => {
            const now = held.current;
            if (now && Math.abs(event.clientY - now.y) > SLOP) now.moved = true;
            if (now?.moved && now.sheet > 0) {
              isDragged.value = true;
              gaps.value = draggedGaps(
                now.gaps,
                now.sheet,
                (now.y - event.clientY) / zoomOf(event.currentTarget),
                ROOM,
              );
              return;
            }
            const hit = plan && cellOn(plan, ...inPicture(event));
            front.value = now ? now.sheet : (hit?.sheet ?? null);
            store.pointer.value = point(hit?.cell);
          }}
          onPointerUp={(event) => {
            const at = point((plan && cellOn(plan, ...inPicture(event)))?.cell);
            if (held.current && !held.current.moved && at) {
              state.asked.value = at;
              state.lastTool.value = state.tool.value = "cost";
            }
            held.current = null;
            isDragged.value = false;
          }}
          onPointerCancel={() => {
            held.current = null;
            isDragged.value = false;
          }}
          onPointerLeave={() => {
            store.pointer.value = front.value = null;
          }}
          style={{ width: "100%", height: `${HEIGHT}px` }}
        />
        {plan &&
          names.map((name, n) => {
            const [, y] = plan.corners[n] as Point;
            const style = { top: `${y - plan.height}px` };
            const show = () => {
              front.value = n;
            };
            const leave = () => {
              front.value = null;
            };
            if (name === "costmap")
              return (
                <span key={name} class="sheets-name" style={style} onPointerEnter={show} onPointerLeave={leave}>
                  All together
                </span>
              );
            return (
              <button
                key={name}
                type="button"
                role="switch"
                class={n === inFront ? "sheets-name sheets-switch in-front" : "sheets-name sheets-switch"}
                aria-checked={isOn(name)}
                style={style}
                onPointerEnter={show}
                onPointerLeave={leave}
                onFocus={show}
                onBlur={leave}
                onClick={() => store.setPart("costmap", { [name]: !isOn(name) })}
              >
                {LAYER_NAMES[name]}
              </button>
            );
          })}
      </div>
      <Slider
        label="Distance between the sheets"
        sentence="Or drag a sheet up or down; click a cell of a sheet to ask for its cost. The sheet under the pointer is shown whole."
        unit="px"
        value={Math.round(gaps.value.reduce((a, b) => a + b, 0) / gaps.value.length)}
        initial={first}
        low={10}
        high={Math.floor(ROOM / (names.length - 1))}
        step={1}
        onInput={(gap) => {
          gaps.value = gaps.peek().map(() => gap);
        }}
      />
    </div>
  );
}

/** A grid as an image, a pixel for each cell, row 0 first; painted again only where its cells have changed. */
export class Sheet {
  #image: HTMLCanvasElement | null = null;
  #key: readonly unknown[] = [];

  /** The image of a map in the colours of a palette, which `theme` stands for. */
  of(map: MapPicture, palette: Palette, theme: unknown): HTMLCanvasElement | null {
    const key = [map.cells, map.cells.revision, theme];
    if (this.#image && key.every((part, i) => part === this.#key[i])) return this.#image;
    this.#key = key;
    const { rows, cols } = map.geometry;
    const image = this.#image ?? document.createElement("canvas");
    if (image.width !== cols || image.height !== rows) {
      image.width = cols;
      image.height = rows;
    }
    const ctx = image.getContext("2d");
    if (!ctx) return null;
    const made = ctx.createImageData(cols, rows);
    fill(new Uint32Array(made.data.buffer), map, new Uint32Array(palette.colours().buffer));
    ctx.putImageData(made, 0, 0);
    this.#image = image;
    return image;
  }
}

function fill(pixels: Uint32Array, { cells, geometry }: MapPicture, colours: Uint32Array): void {
  const { rows, cols } = geometry;
  const tile = new Uint8Array(TILE * TILE);
  pixels.fill(colours[0] as number);
  for (let ty = 0; ty * TILE < rows; ty++) {
    for (let tx = 0; tx * TILE < cols; tx++) {
      if (!cells.readTile(tx, ty, tile)) continue;
      const [high, wide] = [Math.min(TILE, rows - ty * TILE), Math.min(TILE, cols - tx * TILE)];
      for (let r = 0; r < high; r++) {
        const to = (ty * TILE + r) * cols + tx * TILE;
        for (let c = 0; c < wide; c++) pixels[to + c] = colours[tile[r * TILE + c] as number] as number;
      }
    }
  }
}
