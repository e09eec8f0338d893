/** The layers of the costmap in an exploded view: the same cell is marked on each sheet, with its costs. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { type Cell, cellAt, centreOf } from "../../grid/lattice";
import { pictureColours } from "../../render/picture/pictureColours";
import type { Store } from "../../store/store";
import { reducedMotion } from "../../ui/browser/media";
import { useWidth } from "../../ui/browser/useSize";
import { zoomOf } from "../../ui/browser/zoom";
import { Slider } from "../../ui/Slider";
import type { Geometry, Point } from "../../wire/protocol";
import { Sheet } from "./sheetImage";
import { paintCell, paintSheets } from "./sheetPaint";
import { cellOn, draggedGaps, LEAST_GAP, sheetPlan, type Window } from "./sheetPlan";
import { costmapOf } from "./state";
import { LAYER_NAMES } from "./WhyCost";

/** The sheets from the bottom up: the layers, and the costs of all of them. */
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

/** The cells of a world, with a little around it. */
function windowOf(store: Store, geometry: Geometry): Window {
  const bounds = store.world.peek()?.bounds;
  if (!bounds) return { row0: 0, rows: geometry.rows, col0: 0, cols: geometry.cols };
  const low = cellAt(geometry, bounds[0], bounds[1]);
  const high = cellAt(geometry, bounds[2], bounds[3]);
  const [row0, col0] = [Math.max(0, low.row), Math.max(0, low.col)];
  return { row0, col0, rows: Math.min(geometry.rows, high.row) - row0, cols: Math.min(geometry.cols, high.col) - col0 };
}

/** The sheets of the layers that the session has: that of a terrain comes and goes with it. */
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
  const point = (found: Cell | undefined): Point | null => (geometry && found ? centreOf(geometry, found) : null);

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
