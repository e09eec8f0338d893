/** The map by the processor: every pixel in the colour of the cell under its middle, as the shaders of WebGL draw it. */

import { toLattice } from "../../grid/lattice";
import { type Size, toWorld, type View } from "../view";
import { type Cells, NEVER } from "./cells";
import type { MapPicture } from "./mapPicture";
import { CHUNK, levelFor, sideOf } from "./pyramid";

const INSIDE = CHUNK - 1;
const SHIFT = Math.log2(CHUNK);

/**
 * Colour `pixels`, row by row from the upper left corner, `width` to a row. `colours` has one for each byte; what lies
 * outside the map has that of a cell never observed. `size` is the picture's in CSS pixels. Only the columns [from, to)
 * are coloured.
 */
export function rasterise(
  pixels: Uint32Array,
  width: number,
  { geometry, cells }: MapPicture,
  colours: Uint32Array,
  view: View,
  size: Size,
  from = 0,
  to = width,
): void {
  const height = pixels.length / width;
  const ratio = width / size.width;
  const at = (i: number, j: number) =>
    toLattice(geometry, ...toWorld(view, size, (i + 0.5) / ratio, (j + 0.5) / ratio));
  const [u0, v0] = at(0, 0);
  const [ux, vx] = at(1, 0);
  const [uy, vy] = at(0, 1);
  const level = levelFor((ratio * geometry.resolution) / view.scale);
  if (geometry.origin[2] === 0)
    upright(pixels, width, height, cells, colours, level, [u0, ux - u0], [v0, vy - v0], from, to);
  else turned(pixels, width, height, cells, colours, level, [u0, ux - u0, uy - u0], [v0, vx - v0, vy - v0], from, to);
}

/** Rows of cells lie along rows of pixels: each is looked up once, and again where the next row of cells begins. */
function upright(
  pixels: Uint32Array,
  width: number,
  height: number,
  cells: Cells,
  colours: Uint32Array,
  level: number,
  [u0, du]: readonly [number, number],
  [v0, dv]: readonly [number, number],
  from: number,
  to: number,
): void {
  const side = sideOf(level);
  const never = colours[NEVER] as number;
  const cols = Int32Array.from({ length: width }, (_, i) => Math.floor(u0 + i * du));
  const texels = cols.map((col) => (col & INSIDE) >> level);
  let last = Number.NaN;
  for (let j = 0; j < height; j++) {
    const row = Math.floor(v0 + j * dv);
    const start = j * width;
    if (row >> level === last) {
      pixels.copyWithin(start + from, start + from - width, start + to - width);
      continue;
    }
    last = row >> level;
    const base = ((row & INSIDE) >> level) * side;
    for (let i = from; i < to; ) {
      const chunkCol = (cols[i] as number) >> SHIFT;
      let end = i;
      while (end < to && (cols[end] as number) >> SHIFT === chunkCol) end++;
      const bytes = cells.chunk(row >> SHIFT, chunkCol)?.pyramid[level];
      if (bytes) {
        for (; i < end; i++) pixels[start + i] = colours[bytes[base + (texels[i] as number)] as number] as number;
      } else pixels.fill(never, start + i, start + end);
      i = end;
    }
  }
}

/** A grid that is turned in the world: each pixel for itself. */
function turned(
  pixels: Uint32Array,
  width: number,
  height: number,
  cells: Cells,
  colours: Uint32Array,
  level: number,
  [u0, ux, uy]: readonly [number, number, number],
  [v0, vx, vy]: readonly [number, number, number],
  from: number,
  to: number,
): void {
  const side = sideOf(level);
  const never = colours[NEVER] as number;
  let chunkRow = Number.NaN;
  let chunkCol = Number.NaN;
  let bytes: Uint8Array | undefined;
  for (let j = 0; j < height; j++) {
    for (let i = from, at = j * width + from; i < to; i++, at++) {
      const col = Math.floor(u0 + i * ux + j * uy);
      const row = Math.floor(v0 + i * vx + j * vy);
      if (row >> SHIFT !== chunkRow || col >> SHIFT !== chunkCol) {
        chunkRow = row >> SHIFT;
        chunkCol = col >> SHIFT;
        bytes = cells.chunk(chunkRow, chunkCol)?.pyramid[level];
      }
      const texel = ((row & INSIDE) >> level) * side + ((col & INSIDE) >> level);
      pixels[at] = bytes ? (colours[bytes[texel] as number] as number) : never;
    }
  }
}

const BYTES = Uint32Array.from({ length: 256 }, (_, byte) => byte);
let under = new Uint32Array(0);

/**
 * As {@link rasterise}, with colours in four rows, striped as the shader has them (2ⁿ pixels to a stripe), and laid over
 * what is there with their opacity.
 */
export function overlay(
  pixels: Uint32Array,
  width: number,
  map: MapPicture,
  colours: Uint32Array,
  view: View,
  size: Size,
  n: number,
): void {
  if (under.length !== pixels.length) under = new Uint32Array(pixels.length);
  rasterise(under, width, map, BYTES, view, size);
  const height = pixels.length / width;
  for (let j = 0, at = 0; j < height; j++) {
    const up = height - 1 - j; // rows of the shader count from below
    for (let i = 0; i < width; i++, at++) {
      const row = (((i + up) >> n) & 1) + 2 * (((i - up) >> n) & 1);
      const colour = colours[256 * row + (under[at] as number)] as number;
      pixels[at] = colour >>> 24 === 255 ? colour : blended(pixels[at] as number, colour);
    }
  }
}

/** A colour of some opacity over an opaque one, both as the words of an image's bytes. */
function blended(below: number, colour: number): number {
  const alpha = (colour >>> 24) / 255;
  let out = 0xff000000;
  for (const shift of [0, 8, 16]) {
    const [a, b] = [(below >>> shift) & 255, (colour >>> shift) & 255];
    out |= Math.round(a + (b - a) * alpha) << shift;
  }
  return out >>> 0;
}
