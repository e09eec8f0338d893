/** A picture that is one opaque canvas, painted anew each time. */

import { cardContext, paintContext } from "./context";
import { Sheet } from "./sheet";

/** Paints a canvas of the picture's own size, all of it. */
export type PaintWhole = (canvas: HTMLCanvasElement) => void;

export type Surface = (paint: PaintWhole) => void;

/** How a canvas is painted on this machine; `redraw` is called when it must be painted again. */
export function surfaceOn(canvas: HTMLCanvasElement, redraw: () => void): Surface {
  const gl = cardContext(canvas);
  if (gl) return cardSurface(canvas, gl, redraw);
  paintContext(canvas);
  return (paint) => paint(canvas);
}

/**
 * Painted on the processor and shown through WebGL: beside a canvas that the graphics card draws, a 2D canvas would make
 * the browser rasterise the page around it each time.
 */
function cardSurface(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext, redraw: () => void): Surface {
  const painting = document.createElement("canvas");
  let sheet: Sheet | null = null;
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    sheet = null;
  });
  canvas.addEventListener("webglcontextrestored", redraw);
  return (paint) => {
    if (gl.isContextLost()) return;
    sheet ??= new Sheet(gl);
    sized(painting, canvas.width, canvas.height);
    paint(painting);
    gl.viewport(0, 0, canvas.width, canvas.height);
    sheet.draw(painting, true);
  };
}

/** Give a canvas a size in device pixels; setting it clears the canvas, so only where it differs. */
export function sized(canvas: HTMLCanvasElement, width: number, height: number): void {
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
}
