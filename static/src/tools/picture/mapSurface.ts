/** A canvas with a map and an overlay. */

import { CanvasRenderer } from "../../render/map/canvasRenderer";
import { webglContext } from "../../render/map/context";
import { type Layer, type MapRenderer, WebGLRenderer } from "../../render/map/renderer";
import { type Brush, brushOn } from "../../render/picture/brush";
import type { Paint } from "../../render/picture/Picture";
import { pictureColours } from "../../render/picture/pictureColours";
import type { Store } from "../../store/store";

/**
 * Draws maps into a canvas on this machine. `redraw` is called when it must be drawn again although the map has not
 * changed. Throws one clear sentence if the browser cannot draw.
 */
function createRenderer(canvas: HTMLCanvasElement, redraw: () => void): MapRenderer {
  const gl = webglContext(canvas);
  return gl ? new WebGLRenderer(canvas, gl, redraw) : new CanvasRenderer(canvas);
}

interface MapSurface {
  /** Null if the browser cannot draw; `failure` states the reason. */
  readonly renderer: MapRenderer | null;
  readonly failure: string;
  readonly paint: Paint;
}

/**
 * Draw the `layers` in the view of `store` and the overlay that `draw` paints; `draw` returns true while it is
 * animated.
 */
export function mapSurface(
  store: Store,
  canvas: HTMLCanvasElement,
  invalidate: () => void,
  layers: () => readonly Layer[],
  draw: (brush: Brush, now: number) => boolean,
): MapSurface {
  let renderer: MapRenderer | null = null;
  let failure = "";
  try {
    renderer = createRenderer(canvas, invalidate);
  } catch (error) {
    failure = error instanceof Error ? error.message : String(error);
  }
  let colours: unknown = null;
  const paint: Paint = (size, ratio, now) => {
    const view = store.view.peek();
    if (!view || !renderer) return false;
    if (colours !== pictureColours.peek()) {
      colours = pictureColours.peek();
      renderer.recolour();
    }
    let moves = false;
    const isFading = renderer.draw(layers(), view, size, now, (overlay) => {
      const brush = brushOn(overlay, size, ratio, view, pictureColours.peek());
      moves = brush !== null && draw(brush, now);
    });
    return isFading || moves;
  };
  return { renderer, failure, paint };
}
