/** Draws a map into a canvas with WebGL 2: cells with sharp borders at every zoom and pixel ratio, only on request. */

import { fromLattice } from "../../grid/lattice";
import { type Rgb, tokenRgb } from "../../style/colour";
import { TILE } from "../../wire/protocol";
import type { Size, View } from "../view";
import { CanvasOverlay, CORNERS, nearestTexture, vertexArray } from "./canvasOverlay";
import type { Cells, Chunk } from "./cells";
import { Highlights } from "./highlights";
import type { MapPicture } from "./mapPicture";
import { PALETTE_ROWS, type Palette, paletteOf } from "./palettes";
import { CHUNK, LEVELS, levelFor, sideOf } from "./pyramid";
import { CELLS_FRAGMENT, CELLS_VERTEX, HIGHLIGHT_FRAGMENT, HIGHLIGHT_VERTEX, program, uniforms } from "./shaders";
import { type PaintCanvas, resizeCanvas } from "./surface";

/** From this level on a chunk has a small texture of its own, so that a huge map seen whole needs few bytes. */
const COARSE = 3;
/** Large textures kept: 341 kB each. Those not drawn for longest go first. */
const MAX_FINE = 320;
/** With more changed tiles than this a level is sent whole. */
const MANY_TILES = 20;

interface Texture {
  readonly handle: WebGLTexture;
  drawn: number;
}

interface Located {
  readonly texture: WebGLTexture;
  /** Level of the texture that holds the pyramid's level asked for. */
  readonly mip: number;
}

class ChunkTextures {
  readonly #gl: WebGL2RenderingContext;
  readonly #fine = new Map<Chunk, Texture>();
  readonly #coarse = new Map<Chunk, Texture>();

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** Bind nothing, return the texture that holds `level` of a chunk, up to date. `draw` numbers the pictures drawn. */
  locate(chunk: Chunk, level: number, draw: number): Located {
    const isFine = level < COARSE;
    const kind = isFine ? this.#fine : this.#coarse;
    let texture = kind.get(chunk);
    if (!texture) {
      texture = { handle: this.#make(isFine), drawn: draw };
      kind.set(chunk, texture);
      const levels = isFine ? (1 << COARSE) - 1 : ((1 << LEVELS) - 1) & ~((1 << COARSE) - 1);
      for (let tile = 0; tile < chunk.stale.length; tile++) chunk.stale[tile] = (chunk.stale[tile] as number) | levels;
    }
    texture.drawn = draw;
    const mip = isFine ? level : level - COARSE;
    this.#refresh(chunk, level, texture.handle, mip);
    return { texture: texture.handle, mip };
  }

  #make(isFine: boolean): WebGLTexture {
    const gl = this.#gl;
    const handle = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, handle);
    const side = isFine ? CHUNK : sideOf(COARSE);
    gl.texStorage2D(gl.TEXTURE_2D, isFine ? COARSE : LEVELS - COARSE, gl.R8, side, side);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST_MIPMAP_NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return handle;
  }

  #refresh(chunk: Chunk, level: number, handle: WebGLTexture, mip: number): void {
    const bit = 1 << level;
    const { stale } = chunk;
    let count = 0;
    for (const bits of stale) if (bits & bit) count++;
    if (count === 0) return;
    const gl = this.#gl;
    const side = sideOf(level);
    const data = chunk.pyramid[level] as Uint8Array;
    const part = TILE >> level;
    gl.bindTexture(gl.TEXTURE_2D, handle);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (count > MANY_TILES || part < 8) {
      gl.texSubImage2D(gl.TEXTURE_2D, mip, 0, 0, side, side, gl.RED, gl.UNSIGNED_BYTE, data);
    } else {
      gl.pixelStorei(gl.UNPACK_ROW_LENGTH, side);
      for (let tile = 0; tile < stale.length; tile++) {
        if (!((stale[tile] as number) & bit)) continue;
        const x = (tile & 7) * part;
        const y = (tile >> 3) * part;
        gl.texSubImage2D(gl.TEXTURE_2D, mip, x, y, part, part, gl.RED, gl.UNSIGNED_BYTE, data, y * side + x);
      }
      gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
    }
    for (let tile = 0; tile < stale.length; tile++) stale[tile] = (stale[tile] as number) & ~bit;
  }

  /** Drop large textures beyond what is kept; those of the picture `draw` stay. */
  trim(draw: number): void {
    if (this.#fine.size <= MAX_FINE) return;
    const oldest = [...this.#fine].filter(([, { drawn }]) => drawn < draw).sort((a, b) => a[1].drawn - b[1].drawn);
    for (const [chunk, { handle }] of oldest.slice(0, this.#fine.size - MAX_FINE)) {
      this.#gl.deleteTexture(handle);
      this.#fine.delete(chunk);
    }
  }

  clear(): void {
    for (const { handle } of [...this.#fine.values(), ...this.#coarse.values()]) this.#gl.deleteTexture(handle);
    this.#fine.clear();
    this.#coarse.clear();
  }
}

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

/** A map as a layer of a picture; later layers are drawn over earlier ones. */
export interface Layer {
  readonly map: MapPicture | null;
  /** The colours of its bytes; by default those of its style. */
  readonly palette?: Palette;
  /** The part of the picture that shows it, as fractions of its width. The textures of an empty part are kept. */
  readonly part?: readonly [from: number, to: number];
  /** Whether the palette's alpha is used. */
  readonly blends?: boolean;
  /** Whether the highlighted cells belong to this map. */
  readonly hasHighlights?: boolean;
}

/** Number of cached palettes. A palette depends on the limits of the clamp, which a slider can change. */
export const MAX_PALETTES = 16;

/** What depends on the WebGL context and is created again after it was lost. */
interface Resources {
  readonly cells: WebGLProgram;
  readonly cellsAt: Record<
    "u_clip" | "u_box" | "u_cells" | "u_palette" | "u_level" | "u_mip" | "u_stripe",
    WebGLUniformLocation | null
  >;
  readonly highlight: WebGLProgram;
  readonly highlightUniforms: Record<"u_clip" | "u_now" | "u_size" | "u_colour", WebGLUniformLocation | null>;
  readonly quad: WebGLVertexArrayObject;
  readonly points: WebGLVertexArrayObject;
  readonly pointBuffer: WebGLBuffer;
  readonly palettes: Map<string, WebGLTexture>;
  readonly overlay: CanvasOverlay;
  readonly textures: Map<Cells, ChunkTextures>;
}

/** Draws maps into a canvas. */
export interface MapRenderer {
  /** The cells that have just changed. */
  readonly highlights: Highlights;
  /** Read the colours from the page's tokens again at the next drawing. */
  recolour(): void;
  /**
   * Draw maps and, over them, what `over` paints. `size` in CSS pixels, `now` in milliseconds. Returns whether
   * an animation is running.
   */
  draw(layers: readonly Layer[], view: View, size: Size, now: number, over: PaintCanvas): boolean;
}

export class WebGLRenderer implements MapRenderer {
  readonly highlights = new Highlights();
  readonly #overlay = document.createElement("canvas");
  readonly #canvas: HTMLCanvasElement;
  readonly #gl: WebGL2RenderingContext;
  #resources: Resources | null = null;
  #highlighted: Cells | null = null;
  /** The colours of unobserved and of highlighted cells, read from the page's tokens once. */
  #colours: { readonly background: Rgb; readonly highlight: Rgb } | null = null;
  #draws = 0;

  /** `redraw` is called when the canvas must be drawn again although the map is unchanged. */
  constructor(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext, redraw: () => void) {
    this.#canvas = canvas;
    this.#gl = gl;
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.#resources = null;
    });
    canvas.addEventListener("webglcontextrestored", redraw);
  }

  /** Read the colours from the page's tokens again at the next drawing. */
  recolour(): void {
    this.#colours = null;
    if (this.#resources) this.#dropPalettes(this.#resources);
  }

  #dropPalettes({ palettes }: Resources): void {
    for (const texture of palettes.values()) this.#gl.deleteTexture(texture);
    palettes.clear();
  }

  /** Maps and overlay are drawn into one opaque canvas: blending two canvases takes the browser far longer. */
  draw(layers: readonly Layer[], view: View, size: Size, now: number, over: PaintCanvas): boolean {
    const gl = this.#gl;
    if (gl.isContextLost()) return false;
    this.#resources ??= this.#make();
    const made = this.#resources;
    this.#release(made, layers);
    const { width, height } = this.#canvas;
    gl.viewport(0, 0, width, height);
    this.#colours ??= { background: tokenRgb("--map-unobserved"), highlight: tokenRgb("--beam-fill") };
    const [red, green, blue] = this.#colours.background;
    gl.clearColor(red / 255, green / 255, blue / 255, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.#draws++;
    let isFading = false;
    for (const layer of layers) {
      const { map, part = [0, 1] } = layer;
      const [from, to] = part.map((at) => Math.round(at * width)) as [number, number];
      if (!map || from >= to) continue;
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(from, 0, to - from, height);
      const { matrix, cellPx } = clipMatrix(map.geometry, view, size);
      const devicePx = (cellPx * width) / size.width;
      if (layer.blends) {
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      }
      this.#drawCells(made, layer, map, matrix, levelFor(devicePx), width > 1.5 * size.width ? 3 : 2);
      gl.disable(gl.BLEND);
      if (layer.hasHighlights) isFading = this.#drawHighlights(made, matrix, devicePx, now, this.#colours.highlight);
      gl.disable(gl.SCISSOR_TEST);
    }
    const overlay = this.#overlay;
    resizeCanvas(overlay, width, height);
    const context = overlay.getContext("2d", { willReadFrequently: true });
    context?.setTransform(1, 0, 0, 1, 0, 0);
    context?.clearRect(0, 0, overlay.width, overlay.height);
    over(overlay);
    made.overlay.draw(overlay);
    return isFading;
  }

  /** Delete the textures of maps that no layer shows any more. */
  #release(made: Resources, layers: readonly Layer[]): void {
    const highlighted = layers.find((layer) => layer.hasHighlights)?.map?.cells ?? null;
    if (highlighted !== this.#highlighted) this.highlights.clear();
    this.#highlighted = highlighted;
    const shownCells = new Set(layers.map((layer) => layer.map?.cells));
    for (const [cells, textures] of made.textures) {
      if (shownCells.has(cells)) continue;
      textures.clear();
      made.textures.delete(cells);
    }
  }

  #drawCells(
    made: Resources,
    layer: Layer,
    map: MapPicture,
    matrix: Float32Array,
    level: number,
    stripe: number,
  ): void {
    const { cells, geometry } = map;
    const gl = this.#gl;
    let textures = made.textures.get(cells);
    if (!textures) {
      textures = new ChunkTextures(gl);
      made.textures.set(cells, textures);
    }
    gl.useProgram(made.cells);
    gl.bindVertexArray(made.quad);
    gl.uniformMatrix3fv(made.cellsAt.u_clip, false, matrix);
    gl.uniform1i(made.cellsAt.u_level, level);
    gl.uniform1i(made.cellsAt.u_stripe, stripe);
    gl.activeTexture(gl.TEXTURE1);
    this.#bindPalette(made, layer.palette ?? paletteOf(map));
    gl.activeTexture(gl.TEXTURE0);
    for (const chunk of cells.chunks()) {
      const row = chunk.row * CHUNK;
      const col = chunk.col * CHUNK;
      const rows = Math.min(CHUNK, geometry.rows - row);
      const cols = Math.min(CHUNK, geometry.cols - col);
      if (rows <= 0 || cols <= 0 || isOutside(matrix, col, row, cols, rows)) continue;
      const { texture, mip } = textures.locate(chunk, level, this.#draws);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(made.cellsAt.u_mip, mip);
      gl.uniform4f(made.cellsAt.u_box, col, row, cols, rows);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    textures.trim(this.#draws);
  }

  #drawHighlights(
    made: Resources,
    matrix: Float32Array,
    devicePx: number,
    now: number,
    [red, green, blue]: Rgb,
  ): boolean {
    if (!this.highlights.isFading(now)) return false;
    const gl = this.#gl;
    gl.useProgram(made.highlight);
    gl.bindVertexArray(made.points);
    gl.bindBuffer(gl.ARRAY_BUFFER, made.pointBuffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.highlights.data, 0, 3 * this.highlights.count);
    gl.uniformMatrix3fv(made.highlightUniforms.u_clip, false, matrix);
    gl.uniform3f(made.highlightUniforms.u_colour, red / 255, green / 255, blue / 255);
    gl.uniform1f(made.highlightUniforms.u_now, this.highlights.seconds(now));
    gl.uniform1f(made.highlightUniforms.u_size, Math.max(1, Math.ceil(devicePx)));
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawArrays(gl.POINTS, 0, this.highlights.count);
    gl.disable(gl.BLEND);
    return true;
  }

  #bindPalette(made: Resources, { key, colours }: Palette): void {
    const gl = this.#gl;
    const known = made.palettes.get(key);
    if (known) {
      gl.bindTexture(gl.TEXTURE_2D, known);
      return;
    }
    if (made.palettes.size >= MAX_PALETTES) this.#dropPalettes(made);
    const texture = nearestTexture(gl);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, 256, PALETTE_ROWS);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 256, PALETTE_ROWS, gl.RGBA, gl.UNSIGNED_BYTE, colours());
    made.palettes.set(key, texture);
  }

  #make(): Resources {
    const gl = this.#gl;
    const cells = program(gl, CELLS_VERTEX, CELLS_FRAGMENT);
    const highlight = program(gl, HIGHLIGHT_VERTEX, HIGHLIGHT_FRAGMENT);
    const cellsAt = uniforms(gl, cells, ["u_clip", "u_box", "u_cells", "u_palette", "u_level", "u_mip", "u_stripe"]);
    gl.useProgram(cells);
    gl.uniform1i(cellsAt.u_cells, 0);
    gl.uniform1i(cellsAt.u_palette, 1);
    const quad = vertexArray(gl, cells, "a_corner", 2, CORNERS, gl.STATIC_DRAW);
    const points = vertexArray(
      gl,
      highlight,
      "a_cell",
      3,
      new Float32Array(this.highlights.data.length),
      gl.DYNAMIC_DRAW,
    );
    return {
      cells,
      cellsAt,
      highlight,
      highlightUniforms: uniforms(gl, highlight, ["u_clip", "u_now", "u_size", "u_colour"]),
      quad: quad.array,
      points: points.array,
      pointBuffer: points.buffer,
      palettes: new Map(),
      overlay: new CanvasOverlay(gl),
      textures: new Map(),
    };
  }
}

/** Whether a rectangle of the lattice is outside the visible part. */
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
