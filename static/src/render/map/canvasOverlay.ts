/** A painted canvas as a layer of a WebGL picture of the same size. */

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

/** Lays a canvas over what was drawn. */
export class CanvasOverlay {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: WebGLProgram;
  readonly #quad: WebGLVertexArrayObject;
  readonly #texture: WebGLTexture;
  #width = 0;
  #height = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
    this.#program = program(gl, OVERLAY_VERTEX, OVERLAY_FRAGMENT);
    this.#quad = vertexArray(gl, this.#program, "a_corner", 2, CORNERS, gl.STATIC_DRAW).array;
    this.#texture = nearestTexture(gl);
  }

  /** Lay a canvas over all that was drawn; an opaque one replaces it. */
  draw(canvas: HTMLCanvasElement, isOpaque = false): void {
    const gl = this.#gl;
    const { width, height } = canvas;
    gl.useProgram(this.#program);
    gl.bindVertexArray(this.#quad);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    if (this.#width === width && this.#height === height) {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
    } else {
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
      this.#width = width;
      this.#height = height;
    }
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    if (!isOpaque) {
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    }
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.disable(gl.BLEND);
  }
}
