/** The whole map in a corner of a picture that shows a part of it. A click or a drag there moves the picture. */

import { useComputed } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Bounds } from "../../grid/lattice";
import type { MapPicture } from "../../render/map/mapPicture";
import { paletteOf } from "../../render/map/palettes";
import { rasterise } from "../../render/map/raster";
import { pictureColours } from "../../render/picture/pictureColours";
import { fitted, type Size, toScreen, toWorld, type View } from "../../render/view";
import type { Store } from "../../store/store";
import { useSize } from "../../ui/browser/useSize";
import type { Point } from "../../wire/protocol";
import { GIVEN_MAP } from "../localization/model";
import "./picture.css";

/** The largest overview, and the smallest picture that has room for one, CSS px. */
const LARGEST: Size = { width: 168, height: 126 };
const LEAST_PICTURE: Size = { width: 560, height: 360 };
/** The least height or width of the overview of a map as long as a corridor, CSS px. */
const LEAST_SIDE = 28;

/** The bounds of the part of the world that a picture shows. */
function visible(view: View, { width, height }: Size): Bounds {
  const [wide, high] = [(width / 2) * view.scale, (height / 2) * view.scale];
  return [view.x - wide, view.y - high, view.x + wide, view.y + high];
}

interface OverviewBox {
  readonly size: Size;
  /** The view of the whole map in the overview. */
  readonly whole: View;
  /** Left, top, width and height of the part that the picture shows, CSS px in the overview. */
  readonly shown: readonly [left: number, top: number, width: number, height: number];
}

/** The geometry of the overview; null if the picture shows all of `bounds`, or has no room. */
export function overviewBox(bounds: Bounds, view: View, picture: Size): OverviewBox | null {
  if (picture.width < LEAST_PICTURE.width || picture.height < LEAST_PICTURE.height) return null;
  const [x0, y0, x1, y1] = bounds;
  const [left, bottom, right, top] = visible(view, picture);
  if (left <= x0 && bottom <= y0 && right >= x1 && top >= y1) return null;
  const scale = Math.max((x1 - x0) / LARGEST.width, (y1 - y0) / LARGEST.height);
  if (!(scale > 0)) return null;
  const size = {
    width: Math.max(LEAST_SIDE, Math.round((x1 - x0) / scale)),
    height: Math.max(LEAST_SIDE, Math.round((y1 - y0) / scale)),
  };
  const whole = fitted(bounds, size, 0);
  const [px, py] = toScreen(whole, size, left, top);
  const shown = [px, py, (right - left) / whole.scale, (top - bottom) / whole.scale] as const;
  return { size, whole, shown };
}

/** The view centred at a place, or at the nearest place of the map. */
export function centredAt(view: View, [x0, y0, x1, y1]: Bounds, [x, y]: Point): View {
  return { ...view, x: Math.min(x1, Math.max(x0, x)), y: Math.min(y1, Math.max(y0, y)) };
}

/** Pause between two repaints of a changing map, ms. */
const PAUSE_MS = 250;

/** Fills the element that contains the picture, without handling its gestures. */
export function Overview({ store }: { readonly store: Store }) {
  const frame = useRef<HTMLDivElement>(null);
  const size = useSize(frame, 1);
  const box = useComputed(() => {
    const [bounds, view] = [store.bounds.value, store.view.value];
    return bounds && view && store.viewHeld.value ? overviewBox(bounds, view, size.value) : null;
  });
  return (
    <div class="overview-frame" ref={frame}>
      {box.value && <Box store={store} box={box.value} />}
    </div>
  );
}

function Box({ store, box: { size, whole, shown } }: { readonly store: Store; readonly box: OverviewBox }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  /** From the pressed place to the centre of the view, metres; null if nothing is pressed. */
  const held = useRef<Point | null>(null);
  const under = store.underlay.value;
  const map = under === null ? store.map.value : store.layers.grid(under).map.value;
  const version = under === null ? store.mapVersion.value : store.layers.grid(under).version.value;
  const colours = pictureColours.value;
  const painted = useRef({ at: -Infinity, what: "" });
  const what = [whole.x, whole.y, whole.scale, size.width, size.height].join(" ");
  useEffect(() => {
    const paint = (): void => {
      painted.current = { at: performance.now(), what };
      if (canvas.current && map) paintMap(canvas.current, map, whole, size);
    };
    // A map of another size or position is painted at once, because the old image would be at the wrong place.
    const wait = painted.current.what === what ? painted.current.at + PAUSE_MS - performance.now() : 0;
    if (wait <= 0) return paint();
    const timer = setTimeout(paint, wait);
    return () => clearTimeout(timer);
  }, [map, version, colours, what]);

  const placeOf = (event: PointerEvent): Point => {
    const { left, top } = (event.currentTarget as Element).getBoundingClientRect();
    return toWorld(whole, size, event.clientX - left, event.clientY - top);
  };
  const move = (event: PointerEvent): void => {
    const [view, bounds] = [store.view.peek(), store.bounds.peek()];
    if (!held.current || !view || !bounds) return;
    const [x, y] = placeOf(event);
    store.setView(centredAt(view, bounds, [x + held.current[0], y + held.current[1]]));
  };
  const release = (): void => {
    held.current = null;
  };
  const [left, top, width, height] = shown;
  const pose = under === GIVEN_MAP ? null : store.beliefFrame.value?.pose;
  const robot = pose && toScreen(whole, size, pose[0], pose[1]);
  return (
    // The keyboard moves the picture itself.
    <div
      class="overview"
      aria-hidden="true"
      title="The whole map: click or drag to move the view"
      style={{ width: `${size.width}px`, height: `${size.height}px` }}
      onPointerDown={(event) => {
        const view = store.view.peek();
        if (event.button !== 0 || !view) return;
        event.preventDefault();
        event.currentTarget.setPointerCapture(event.pointerId);
        const [x, y] = placeOf(event);
        const [px, py] = toScreen(whole, size, x, y);
        const isOnShown = px >= left && px <= left + width && py >= top && py <= top + height;
        held.current = isOnShown ? [view.x - x, view.y - y] : [0, 0];
        move(event);
      }}
      onPointerMove={move}
      onPointerUp={release}
      onPointerCancel={release}
    >
      <canvas ref={canvas} />
      {robot && <span class="overview-robot" style={{ left: `${robot[0]}px`, top: `${robot[1]}px` }} />}
      <span
        class="overview-shown"
        style={{ left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` }}
      />
    </div>
  );
}

function paintMap(canvas: HTMLCanvasElement, map: MapPicture, whole: OverviewBox["whole"], size: Size): void {
  const [width, height] = [size.width, size.height].map((side) => Math.round(side * devicePixelRatio)) as [
    number,
    number,
  ];
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d");
  if (!context) return;
  const image = context.createImageData(width, height);
  const colours = new Uint32Array(paletteOf(map).colours().buffer);
  rasterise(new Uint32Array(image.data.buffer), width, map, colours, whole, size);
  context.putImageData(image, 0, 0);
}
