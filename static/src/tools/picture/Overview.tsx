/** The whole map in a corner of a picture that shows a part of it; a click or a drag there moves the picture. */

import { useComputed } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { MapPicture } from "../../render/map/mapPicture";
import { paletteOf } from "../../render/map/palettes";
import { rasterise } from "../../render/map/raster";
import { pictureColours } from "../../render/picture/pictureColours";
import { type Size, toScreen, toWorld } from "../../render/view";
import type { Store } from "../../store/store";
import { useSize } from "../../ui/browser/useSize";
import type { Point } from "../../wire/protocol";
import { GIVEN_MAP } from "../localization/model";
import { centredAt, type OverviewBox, overviewBox } from "./overviewBox";
import "./picture.css";

/** Between two paintings of a map that changes, ms. */
const PAUSE_MS = 250;

/** Fills the element that contains the picture, without taking its gestures. */
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
  /** From the place that is pressed to the centre of the view, metres; null while nothing is pressed. */
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
    // A map of another size or place at once, as what is painted would be at the wrong place.
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
