/** Draws a map into a canvas with a graphics card: crisp cells at every zoom and pixel ratio, and only when asked to. */

import { fromLattice } from "../lattice";
import type { Geometry } from "../protocol";
import type { MapPicture } from "../shownMap";
import { tokenRgb } from "../style/colour";
import type { Size, View } from "../view";
import type { Cells } from "./cells";
import { Glow } from "./glow";
import { mapColours, palette } from "./palette";
import { CHUNK, levelFor } from "./pyramid";
import { CELLS_FRAGMENT, CELLS_VERTEX, GLOW_FRAGMENT, GLOW_VERTEX, program, uniforms } from "./shaders";
import { CORNERS, nearestTexture, Sheet, vertexArray } from "./sheet";
import { type PaintWhole, sized } from "./surface";
import { ChunkTextures } from "./textures";

/** Lattice (column, row) → clip space, column-major 3 × 3, and how many device pixels a cell is wide. */
export function clipMatrix(
  geometry: MapPicture["geometry"],
  view: View,
  size: Size,
): { readonly matrix: Float32Array; readonly cellPx: number } {
  const sx = 2 / (size.width * view.scale);
  const sy = 2 / (size.height * view.scale);
  const [ox, oy] = fromLattice(geometry, 0, 0);
  const c = Math.cos(geometry.origin[2]) * geometry.resolution;
  const s = Math.sin(geometry.origin[2]) * geometry.resolution;
  const matrix = new Float32Array([c * sx, s * sy, 0, -s * sx, c * sy, 0, (ox - view.x) * sx, (oy - view.y) * sy, 1]);
  return { matrix, cellPx: geometry.resolution / view.scale };
}

/** Before a map has come only the colour of what was never observed is needed. */
export const ANY_RANGE = { log_odds_min: -1, log_odds_max: 1 };

/** What depends on the context and is made anew when it was lost. */
interface Resources {
  readonly cells: WebGLProgram;
  readonly cellsAt: Record<
    "u_clip" | "u_box" | "u_cells" | "u_palette" | "u_level" | "u_mip",
    WebGLUniformLocation | null
  >;
  readonly glow: WebGLProgram;
  readonly glowAt: Record<"u_clip" | "u_now" | "u_size" | "u_colour", WebGLUniformLocation | null>;
  readonly quad: WebGLVertexArrayObject;
  readonly points: WebGLVertexArrayObject;
  readonly pointBuffer: WebGLBuffer;
  readonly palette: WebGLTexture;
  readonly overlay: Sheet;
  readonly textures: ChunkTextures;
}

/** Draws maps into a canvas. */
export interface MapRenderer {
  /** The cells that have just changed. */
  readonly glow: Glow;
  /** Colours are read from the page's tokens anew with the next drawing. */
  recolour(): void;
  /**
   * Draw a map and, over it, what `over` paints. `size` in CSS pixels, `now` in milliseconds. Says whether something
   * still moves.
   */
  draw(map: MapPicture | null, view: View, size: Size, now: number, over: PaintWhole): boolean;
}

export class CardRenderer implements MapRenderer {
  readonly glow = new Glow();
  readonly #overlay = document.createElement("canvas");
  readonly #canvas: HTMLCanvasElement;
  readonly #gl: WebGL2RenderingContext;
  #resources: Resources | null = null;
  #shown: Cells | null = null;
  #paletteKey = "";
  #background: readonly number[] = [0, 0, 0];
  #draws = 0;

  /** `redraw` is called when the canvas must be drawn again although nothing of the map changed. */
  constructor(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext, redraw: () => void) {
    this.#canvas = canvas;
    this.#gl = gl;
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.#resources = null;
    });
    canvas.addEventListener("webglcontextrestored", redraw);
  }

  /** Colours are read from the page's tokens anew with the next drawing. */
  recolour(): void {
    this.#paletteKey = "";
  }

  /**
   * One opaque canvas with map and overlay in it costs the browser far less than two that it has to blend.
   */
  draw(map: MapPicture | null, view: View, size: Size, now: number, over: PaintWhole): boolean {
    const gl = this.#gl;
    if (gl.isContextLost()) return false;
    this.#resources ??= this.#make();
    const made = this.#resources;
    const cells = map?.cells ?? null;
    if (cells !== this.#shown) {
      made.textures.clear();
      this.glow.clear();
      this.#shown = cells;
    }
    this.#usePalette(made, map?.geometry ?? ANY_RANGE);
    gl.viewport(0, 0, this.#canvas.width, this.#canvas.height);
    const [red, green, blue] = this.#background as [number, number, number];
    gl.clearColor(red / 255, green / 255, blue / 255, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    let glows = false;
    if (map) {
      const { matrix, cellPx } = clipMatrix(map.geometry, view, size);
      const devicePx = (cellPx * this.#canvas.width) / size.width;
      this.#drawCells(made, map, matrix, levelFor(devicePx));
      glows = this.#drawGlow(made, matrix, devicePx, now);
    }
    const overlay = this.#overlay;
    sized(overlay, this.#canvas.width, this.#canvas.height);
    const context = overlay.getContext("2d", { willReadFrequently: true });
    context?.setTransform(1, 0, 0, 1, 0, 0);
    context?.clearRect(0, 0, overlay.width, overlay.height);
    over(overlay);
    made.overlay.draw(overlay);
    return glows;
  }

  #drawCells(made: Resources, { geometry, cells }: MapPicture, matrix: Float32Array, level: number): void {
    const gl = this.#gl;
    this.#draws++;
    gl.useProgram(made.cells);
    gl.bindVertexArray(made.quad);
    gl.uniformMatrix3fv(made.cellsAt.u_clip, false, matrix);
    gl.uniform1i(made.cellsAt.u_level, level);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, made.palette);
    gl.activeTexture(gl.TEXTURE0);
    for (const chunk of cells.chunks()) {
      const row = chunk.row * CHUNK;
      const col = chunk.col * CHUNK;
      const rows = Math.min(CHUNK, geometry.rows - row);
      const cols = Math.min(CHUNK, geometry.cols - col);
      if (rows <= 0 || cols <= 0 || isOutside(matrix, col, row, cols, rows)) continue;
      const { texture, mip } = made.textures.locate(chunk, level, this.#draws);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(made.cellsAt.u_mip, mip);
      gl.uniform4f(made.cellsAt.u_box, col, row, cols, rows);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    made.textures.trim(this.#draws);
  }

  #drawGlow(made: Resources, matrix: Float32Array, devicePx: number, now: number): boolean {
    if (!this.glow.isAlive(now)) return false;
    const gl = this.#gl;
    gl.useProgram(made.glow);
    gl.bindVertexArray(made.points);
    gl.bindBuffer(gl.ARRAY_BUFFER, made.pointBuffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.glow.data, 0, 3 * this.glow.count);
    gl.uniformMatrix3fv(made.glowAt.u_clip, false, matrix);
    gl.uniform1f(made.glowAt.u_now, this.glow.seconds(now));
    gl.uniform1f(made.glowAt.u_size, Math.max(1, Math.ceil(devicePx)));
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawArrays(gl.POINTS, 0, this.glow.count);
    gl.disable(gl.BLEND);
    return true;
  }

  #usePalette(made: Resources, range: Pick<Geometry, "log_odds_min" | "log_odds_max">): void {
    const key = `${range.log_odds_min} ${range.log_odds_max}`;
    if (key === this.#paletteKey) return;
    this.#paletteKey = key;
    const gl = this.#gl;
    const colours = mapColours();
    this.#background = colours.unobserved;
    gl.bindTexture(gl.TEXTURE_2D, made.palette);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 256, 1, gl.RGBA, gl.UNSIGNED_BYTE, palette(range, colours));
    const [red, green, blue] = tokenRgb("--beam-fill");
    gl.useProgram(made.glow);
    gl.uniform3f(made.glowAt.u_colour, red / 255, green / 255, blue / 255);
  }

  #make(): Resources {
    const gl = this.#gl;
    this.#paletteKey = "";
    const cells = program(gl, CELLS_VERTEX, CELLS_FRAGMENT);
    const glow = program(gl, GLOW_VERTEX, GLOW_FRAGMENT);
    const cellsAt = uniforms(gl, cells, ["u_clip", "u_box", "u_cells", "u_palette", "u_level", "u_mip"]);
    gl.useProgram(cells);
    gl.uniform1i(cellsAt.u_cells, 0);
    gl.uniform1i(cellsAt.u_palette, 1);
    const quad = vertexArray(gl, cells, "a_corner", 2, CORNERS, gl.STATIC_DRAW);
    const points = vertexArray(gl, glow, "a_cell", 3, new Float32Array(this.glow.data.length), gl.DYNAMIC_DRAW);
    const colours = nearestTexture(gl);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, 256, 1);
    return {
      cells,
      cellsAt,
      glow,
      glowAt: uniforms(gl, glow, ["u_clip", "u_now", "u_size", "u_colour"]),
      quad: quad.array,
      points: points.array,
      pointBuffer: points.buffer,
      palette: colours,
      overlay: new Sheet(gl),
      textures: new ChunkTextures(gl),
    };
  }
}

/** Whether a rectangle of the lattice lies outside what is seen. */
function isOutside(m: Float32Array, col: number, row: number, cols: number, rows: number): boolean {
  let left = 0;
  let right = 0;
  let below = 0;
  let above = 0;
  for (const [u, v] of [
    [col, row],
    [col + cols, row],
    [col, row + rows],
    [col + cols, row + rows],
  ] as const) {
    const x = (m[0] as number) * u + (m[3] as number) * v + (m[6] as number);
    const y = (m[1] as number) * u + (m[4] as number) * v + (m[7] as number);
    if (x < -1) left++;
    if (x > 1) right++;
    if (y < -1) below++;
    if (y > 1) above++;
  }
  return left === 4 || right === 4 || below === 4 || above === 4;
}
