/**
 * With what a picture is drawn: by a graphics card through WebGL, or by the processor into a 2D canvas.
 *
 * A browser without a graphics card may still offer WebGL. It then computes every pixel in a program that plays the
 * card, reads the picture back and hands it on: several times the work of painting it at once.
 */

const ATTRIBUTES: WebGLContextAttributes = {
  alpha: false,
  antialias: false,
  depth: false,
  stencil: false,
  failIfMajorPerformanceCaveat: true,
};

/** How the programs call themselves that play a graphics card: Chromium's, Mesa's two, those of macOS and Windows. */
const SOFTWARE_RENDERERS = /swiftshader|llvmpipe|softpipe|software|basic render/i;

export const isSoftwareRenderer = (renderer: string): boolean => SOFTWARE_RENDERERS.test(renderer);

let hasGraphicsCard: boolean | undefined;

/** Ask once, with a canvas of its own: one that has given a WebGL context gives no other. */
function findGraphicsCard(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2", ATTRIBUTES);
  if (!gl) return false;
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = String(gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return !isSoftwareRenderer(renderer);
}

/** A WebGL 2 context for an opaque picture; null where no graphics card would draw it. */
export function webglContext(canvas: HTMLCanvasElement): WebGL2RenderingContext | null {
  hasGraphicsCard ??= findGraphicsCard();
  return hasGraphicsCard ? canvas.getContext("webgl2", ATTRIBUTES) : null;
}

/** A 2D context for an opaque picture that the processor paints; throws one clear sentence where the browser has none. */
export function canvasContext(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const context = canvas.getContext("2d", { alpha: false, willReadFrequently: true });
  if (!context) throw new Error("This browser offers no canvas, on which the pictures are drawn.");
  canvas.style.willChange = "transform";
  return context;
}
