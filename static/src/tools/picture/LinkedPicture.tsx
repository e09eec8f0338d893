/** A picture of the world that shares view, pointer and robot with the other pictures of the same store. */

import { effect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { robotPx } from "../../render/picture/brush";
import { listen } from "../../render/picture/gestures";
import { type Paint, Picture } from "../../render/picture/Picture";
import { panned, type Size, toScreen, toWorld, zoomedAt } from "../../render/view";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { brushStroke, isOnGoal, paints, useTool } from "../costmap/mapTool";
import { stroke } from "../editing/strokes";
import { listenToKeys } from "./keyboard";
import "./picture.css";
import { pathOf } from "../path/state";

/** A tool that draws in a picture; places are in the world. */
interface PictureTool {
  draws(): boolean;
  /** A stroke from `from` so far to `to`, null if it was cancelled. */
  stroke(from: Point | null, to: Point | null, isDone: boolean): void;
  /** A tap or click; true if it was handled. */
  tap?(point: Point): boolean;
  /** A key of the focused picture; true if it was handled. */
  key(key: string): boolean;
}

interface LinkedPictureProps {
  readonly store: Store;
  /** Description for screen readers. */
  readonly label: string;
  /** Called once with the canvas. `paint` paints it; `watch` reads every signal that the picture shows. */
  readonly setUp: (
    canvas: HTMLCanvasElement,
    invalidate: () => void,
  ) => { readonly paint: Paint; readonly watch: () => void; readonly dispose?: () => void };
  /** A tap or click on a place of the world. */
  readonly onTap: (point: readonly [number, number]) => void;
  readonly onPicture?: (picture: Picture) => void;
  /** Whether the editing tools work in this picture. */
  readonly draws?: boolean;
  /** A tool that handles drags in this picture while it `draws`, and first handles its taps and keys. */
  readonly tool?: PictureTool;
  readonly children?: ComponentChildren;
}

export function LinkedPicture({
  store,
  label,
  setUp,
  onTap,
  onPicture,
  draws = false,
  tool,
  children,
}: LinkedPictureProps) {
  const frame = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const element = frame.current;
    const surface = canvas.current;
    if (!element || !surface) return;
    let invalidate = (): void => undefined;
    const made = setUp(surface, () => invalidate());
    const follow = (size: Size): void => {
      store.pictures.set(element, size);
      store.fitView();
    };
    const picture = new Picture(element, surface, made.paint, follow);
    invalidate = picture.invalidate;
    onPicture?.(picture);

    const inWorld = (x: number, y: number): readonly [number, number] | null => {
      const view = store.view.peek();
      return view && toWorld(view, picture.size, x, y);
    };
    let holdsGoal = false;
    const stops = [
      effect(() => {
        void store.bounds.value;
        if (!store.viewHeld.value && picture.size.width > 0) store.fitView();
      }),
      effect(() => {
        surface.hidden = store.view.value === null; // an opaque canvas is black until it is painted
        made.watch();
        picture.invalidate();
      }),
      listen(element, {
        grabs: (x, y, reach) => {
          const view = store.view.peek();
          const pose = store.frame.peek()?.pose;
          if (draws && store.editing.tool.peek() !== null) return false;
          if (!view) return false;
          holdsGoal = isOnGoal(store, x, y, reach, (point) => toScreen(view, picture.size, ...point));
          if (holdsGoal) return true;
          if (!pose || !store.isDriven.peek()) return false;
          const [rx, ry] = toScreen(view, picture.size, pose[0], pose[1]);
          return Math.hypot(x - rx, y - ry) <= robotPx(view) + reach;
        },
        tap: (x, y) => {
          const point = inWorld(x, y);
          if (point && !tool?.tap?.(point) && !useTool(store, point)) onTap(point);
        },
        explain: (x, y) => {
          const point = inWorld(x, y);
          if (point) store.explain(point);
        },
        doubleTap: (x, y) => {
          const point = inWorld(x, y);
          // The two sides of a door are close to each other if it is small in the picture.
          if (!point || !tool?.tap?.(point)) store.viewHeld.value = false;
        },
        dragRobot: (at) => {
          const to = at && inWorld(at[0], at[1]);
          if (holdsGoal) pathOf(store).dragGoal(to);
          else store.dragRobot(to);
        },
        draws: () =>
          tool?.draws() ||
          paints(store) ||
          (draws && (store.editing.tool.peek() === "wall" || store.editing.tool.peek() === "box")),
        stroke: (from, to, isDone) => {
          const start = inWorld(from[0], from[1]);
          const end = to && inWorld(to[0], to[1]);
          if (tool?.draws()) tool.stroke(start, end, isDone);
          else if (paints(store)) brushStroke(store, start, end, isDone);
          else stroke(store, start, end, isDone);
        },
        pan: (dx, dy) => {
          const view = store.view.peek();
          if (view) store.setView(panned(view, dx, dy));
        },
        zoom: (x, y, factor) => {
          const view = store.view.peek();
          if (view) store.setView(zoomedAt(view, picture.size, x, y, factor));
        },
        hover: (at) => {
          store.pointer.value = at && inWorld(at[0], at[1]);
        },
      }),
      listenToKeys(
        element,
        store,
        () => picture.size,
        (key) => tool?.key(key) ?? false,
      ),
      () => picture.dispose(),
      () => {
        store.pictures.delete(element);
        store.fitView();
      },
      () => made.dispose?.(),
    ];
    return () => {
      for (const stop of stops) stop();
    };
  }, [store]);

  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it is an application: keys drive the robot and move the cursor
    <div class="picture" ref={frame} role="application" aria-label={label} tabIndex={0}>
      <canvas ref={canvas} />
      {children}
    </div>
  );
}
