import { CanvasRenderer } from "./canvasRenderer";
import { webglContext } from "./context";
import { type MapRenderer, WebGLRenderer } from "./renderer";

/**
 * How maps are drawn into a canvas on this machine; `redraw` is called when it must be drawn again although nothing of
 * the map changed. Throws one clear sentence where the browser can draw nothing.
 */
export function createRenderer(canvas: HTMLCanvasElement, redraw: () => void): MapRenderer {
  const gl = webglContext(canvas);
  return gl ? new WebGLRenderer(canvas, gl, redraw) : new CanvasRenderer(canvas);
}
