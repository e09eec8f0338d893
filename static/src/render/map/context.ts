/**
 * The context of a picture's canvas: WebGL with a graphics card, otherwise a 2D canvas.
 *
 * A browser without a graphics card may still offer WebGL. It then emulates the card in software and copies the picture,
 * which takes several times as long as painting into a 2D canvas.
 */

const ATTRIBUTES: WebGLContextAttributes = {
  alpha: false,
  antialias: false,
  depth: false,
  stencil: false,
  failIfMajorPerformanceCaveat: true,
};

/** Names of software renderers: Chromium's, Mesa's two, those of macOS and Windows. */
const SOFTWARE_RENDERERS = /swiftshader|llvmpipe|softpipe|software|basic render/i;

export const isSoftwareRenderer = (renderer: string): boolean => SOFTWARE_RENDERERS.test(renderer);

let found: boolean | undefined;

/** With a separate canvas: a canvas with a WebGL context can have no other context. */
function findGraphicsCard(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2", ATTRIBUTES);
  if (!gl) return false;
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = String(gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return !isSoftwareRenderer(renderer);
}

/** Whether a graphics card would draw WebGL 2. Determined once. */
export function hasGraphicsCard(): boolean {
  found ??= findGraphicsCard();
  return found;
}

/** A WebGL 2 context for an opaque picture; null where no graphics card would draw it. */
export const webglContext = (canvas: HTMLCanvasElement): WebGL2RenderingContext | null =>
  hasGraphicsCard() ? canvas.getContext("webgl2", ATTRIBUTES) : null;

/** A 2D context for an opaque picture that the processor paints; throws if the browser has none. */
export function canvasContext(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const context = canvas.getContext("2d", { alpha: false, willReadFrequently: true });
  if (!context) throw new Error("This browser offers no canvas, on which the pictures are drawn.");
  canvas.style.willChange = "transform";
  return context;
}
