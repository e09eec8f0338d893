import { cardContext } from "./context";
import { PaintRenderer } from "./painter";
import { CardRenderer, type MapRenderer } from "./renderer";

/**
 * How maps are drawn into a canvas on this machine; `redraw` is called when it must be drawn again although nothing of
 * the map changed. Throws one clear sentence where the browser can draw nothing.
 */
export function rendererOn(canvas: HTMLCanvasElement, redraw: () => void): MapRenderer {
  const gl = cardContext(canvas);
  return gl ? new CardRenderer(canvas, gl, redraw) : new PaintRenderer(canvas);
}
