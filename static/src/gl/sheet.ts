/** A 2D canvas laid over a WebGL picture of the same size. */

import { OVERLAY_FRAGMENT, OVERLAY_VERTEX, program } from "./shaders";

/** A new texture, bound, that is looked up without blending between texels. */
export function nearestTexture(gl: WebGL2RenderingContext): WebGLTexture {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return texture;
}

/** A vertex array with one attribute of `size` floats, and its buffer. */
export function vertexArray(
  gl: WebGL2RenderingContext,
  of: WebGLProgram,
  attribute: string,
  size: number,
  data: Float32Array<ArrayBuffer>,
  usage: number,
): { readonly array: WebGLVertexArrayObject; readonly buffer: WebGLBuffer } {
  const array = gl.createVertexArray();
  const buffer = gl.createBuffer();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, usage);
  const at = gl.getAttribLocation(of, attribute);
  gl.enableVertexAttribArray(at);
  gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
  return { array, buffer };
}

/** The corners of a unit square as a triangle strip. */
export const CORNERS = new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]);

/** Puts canvases over the picture, one after the other; each keeps the texture it was last given. */
export class Sheets {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: WebGLProgram;
  readonly #quad: WebGLVertexArrayObject;
  readonly #textures: WebGLTexture[];

  constructor(gl: WebGL2RenderingContext, count: number) {
    this.#gl = gl;
    this.#program = program(gl, OVERLAY_VERTEX, OVERLAY_FRAGMENT);
    this.#quad = vertexArray(gl, this.#program, "a_corner", 2, CORNERS, gl.STATIC_DRAW).array;
    this.#textures = Array.from({ length: count }, () => nearestTexture(gl));
  }

  /** Lay sheet `index` over the picture; with `canvas` it first takes that canvas's pixels. */
  draw(index: number, canvas: HTMLCanvasElement | null): void {
    const gl = this.#gl;
    gl.useProgram(this.#program);
    gl.bindVertexArray(this.#quad);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.#textures[index] as WebGLTexture);
    if (canvas) {
      gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
      gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.disable(gl.BLEND);
  }
}

/** A WebGL 2 context for an opaque picture; throws one clear sentence where the browser has none. */
export function contextOf(canvas: HTMLCanvasElement): WebGL2RenderingContext {
  const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, stencil: false });
  if (!gl) throw new Error("This browser offers no WebGL 2, with which the pictures are drawn.");
  return gl;
}

/**
 * A picture that is only sheets: an opaque one at the bottom that changes seldom, one over it that changes often. What
 * is painted on the processor and uploaded costs the same everywhere; a 2D canvas in the page would, without graphics
 * hardware, make the browser rasterise the page around it with every frame.
 */
export class SheetRenderer {
  readonly #canvas: HTMLCanvasElement;
  readonly #gl: WebGL2RenderingContext;
  #sheets: Sheets | null = null;

  constructor(canvas: HTMLCanvasElement, redraw: () => void) {
    this.#canvas = canvas;
    this.#gl = contextOf(canvas);
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.#sheets = null;
    });
    canvas.addEventListener("webglcontextrestored", redraw);
  }

  /** Draw both sheets; the lower one is read only when `lowerChanged`. */
  draw(lower: HTMLCanvasElement, lowerChanged: boolean, upper: HTMLCanvasElement): void {
    const gl = this.#gl;
    if (gl.isContextLost()) return;
    const isNew = this.#sheets === null;
    this.#sheets ??= new Sheets(gl, 2);
    gl.viewport(0, 0, this.#canvas.width, this.#canvas.height);
    this.#sheets.draw(0, lowerChanged || isNew ? lower : null);
    this.#sheets.draw(1, upper);
  }
}
