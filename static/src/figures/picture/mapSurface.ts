/** A map by WebGL with a drawing over it: the canvas of every belief. */

import { MapRenderer } from "../../gl/renderer";
import type { Store } from "../../state";
import { type Brush, brushOn } from "./brush";
import { inks } from "./inks";
import { type Paint, sized } from "./Picture";

interface MapSurface {
  /** Null where the browser has no WebGL; `failure` says why. */
  readonly renderer: MapRenderer | null;
  readonly failure: string;
  readonly paint: Paint;
}

/** Draw what `map` returns in the view of `store`, and over it what `draw` paints; true while that moves by itself. */
export function mapSurface(
  store: Store,
  canvas: HTMLCanvasElement,
  invalidate: () => void,
  map: () => Parameters<MapRenderer["draw"]>[0],
  draw: (brush: Brush, now: number) => boolean,
): MapSurface {
  const overlay = document.createElement("canvas");
  let renderer: MapRenderer | null = null;
  let failure = "";
  try {
    renderer = new MapRenderer(canvas, invalidate);
  } catch (error) {
    failure = error instanceof Error ? error.message : String(error);
  }
  let colours: unknown = null;
  const paint: Paint = (size, ratio, now) => {
    const view = store.view.peek();
    if (!view || !renderer) return false;
    if (colours !== inks.peek()) {
      colours = inks.peek();
      renderer.recolour();
    }
    sized(overlay, canvas.width, canvas.height);
    const brush = brushOn(overlay, size, ratio, view, inks.peek());
    brush?.ctx.clearRect(0, 0, size.width, size.height);
    const moves = brush !== null && draw(brush, now);
    return renderer.draw(map(), overlay, view, size, now) || moves;
  };
  return { renderer, failure, paint };
}
