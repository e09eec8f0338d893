/** A picture that is one opaque canvas, painted again each time. */

import { CanvasOverlay } from "./canvasOverlay";
import { canvasContext, webglContext } from "./context";

/** Paints a canvas of the picture's own size, all of it. */
export type PaintCanvas = (canvas: HTMLCanvasElement) => void;

export type Surface = (paint: PaintCanvas) => void;

/** The way to paint a canvas on this machine; `redraw` is called when it must be painted again. */
export function createSurface(canvas: HTMLCanvasElement, redraw: () => void): Surface {
  const gl = webglContext(canvas);
  if (gl) return webglSurface(canvas, gl, redraw);
  canvasContext(canvas);
  return (paint) => paint(canvas);
}

/**
 * Painted on the processor and shown through WebGL: beside a canvas that the graphics card draws, a 2D canvas would make
 * the browser rasterise the page around it each time.
 */
function webglSurface(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext, redraw: () => void): Surface {
  const painting = document.createElement("canvas");
  let sheet: CanvasOverlay | null = null;
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    sheet = null;
  });
  canvas.addEventListener("webglcontextrestored", redraw);
  return (paint) => {
    if (gl.isContextLost()) return;
    sheet ??= new CanvasOverlay(gl);
    resizeCanvas(painting, canvas.width, canvas.height);
    paint(painting);
    gl.viewport(0, 0, canvas.width, canvas.height);
    sheet.draw(painting, true);
  };
}

/** Give a canvas a size in device pixels; setting it clears the canvas, so only where it differs. */
export function resizeCanvas(canvas: HTMLCanvasElement, width: number, height: number): void {
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
}
