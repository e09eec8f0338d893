/** What is painted over a map: the points, paths and graphs of a session's layers, each by the painter of its style. */

import type { LayerKind } from "../../wire/protocol";
import { toScreen } from "../view";
import type { Brush } from "./brush";
import { SHADES } from "./pictureColours";

/** Write a square of `side` pixels around (x, y) into `pixels` (rows of `width`); what is outside is left out. */
export function stamp(
  pixels: Uint32Array,
  width: number,
  height: number,
  x: number,
  y: number,
  side: number,
  colour: number,
): void {
  const left = Math.max(0, Math.round(x - side / 2));
  const top = Math.max(0, Math.round(y - side / 2));
  const right = Math.min(width, Math.round(x - side / 2) + side);
  const bottom = Math.min(height, Math.round(y - side / 2) + side);
  for (let row = top; row < bottom; row++) for (let col = left; col < right; col++) pixels[row * width + col] = colour;
}

/** CSS colours as pixels have them, in the machine's order of bytes. */
function packed(colours: readonly string[]): Uint32Array {
  const canvas = document.createElement("canvas");
  canvas.width = colours.length;
  canvas.height = 1;
  const ctx = canvas.getContext("2d", { willReadFrequently: true });
  if (!ctx) return new Uint32Array(colours.length);
  for (const [i, colour] of colours.entries()) {
    ctx.fillStyle = colour;
    ctx.fillRect(i, 0, 1, 1);
  }
  return new Uint32Array(ctx.getImageData(0, 0, colours.length, 1).data.buffer);
}

interface Sheet {
  readonly canvas: HTMLCanvasElement;
  readonly ctx: CanvasRenderingContext2D;
  readonly image: ImageData;
  readonly pixels: Uint32Array;
}

let sheet: Sheet | null = null;
const palettes = new WeakMap<readonly string[], Uint32Array>();

function sheetOf(width: number, height: number): Sheet | null {
  if (sheet?.image.width === width && sheet.image.height === height) {
    sheet.pixels.fill(0);
    return sheet;
  }
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const ctx = canvas.getContext("2d", { willReadFrequently: true });
  if (!ctx) return null;
  const image = ctx.createImageData(width, height);
  sheet = { canvas, ctx, image, pixels: new Uint32Array(image.data.buffer) };
  return sheet;
}

/**
 * Paint a dot of `side` CSS pixels at each (x, y), CSS pixels, in the colour of its shade; NaN is no dot.
 * Returns false where the browser gives no canvas for it.
 */
function paintDots(
  { ctx, size }: Brush,
  xs: Float32Array,
  ys: Float32Array,
  shades: Uint8Array | null,
  colours: readonly string[],
  side: number,
): boolean {
  const ratio = ctx.getTransform().a;
  const width = Math.max(1, Math.round(size.width * ratio));
  const height = Math.max(1, Math.round(size.height * ratio));
  const made = sheetOf(width, height);
  if (!made) return false;
  let palette = palettes.get(colours);
  if (!palette) {
    palette = packed(colours);
    palettes.set(colours, palette);
  }
  const pixels = Math.max(1, Math.round(side * ratio));
  for (let i = 0; i < xs.length; i++) {
    const x = (xs[i] as number) * ratio;
    const y = (ys[i] as number) * ratio;
    if (!(x >= 0 && y >= 0 && x <= width && y <= height)) continue;
    stamp(made.pixels, width, height, x, y, pixels, palette[shades ? (shades[i] as number) : 0] as number);
  }
  made.ctx.putImageData(made.image, 0, 0);
  ctx.save();
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  ctx.drawImage(made.canvas, 0, 0);
  ctx.restore();
  return true;
}

/** The content of a layer. Places are in metres of the map frame, angles in radians; NaN is no value. */
export interface LayerContent {
  readonly kind: Exclude<LayerKind, "grid">;
  readonly style: string;
  /** Names of the columns: `x`, `y`, and perhaps `yaw`, `value` and others. */
  readonly names: readonly string[];
  readonly columns: readonly Float32Array[];
  /** Of each edge of a graph the places of its two nodes, one after the other. */
  readonly edges: Uint32Array | null;
  /** Of each edge its value. */
  readonly values: Float32Array | null;
}

export type Overlay = (brush: Brush, content: LayerContent) => void;

/** Painters by style. A layer of a style that is not here is painted by the painter of its kind. */
export const OVERLAYS: Record<string, Overlay> = {};

const DOT_PX = 3;
const ARROW_PX = 9;
/** With more points on the screen than this only some of them have arrows. */
const MAX_ARROWS = 2000;
/** More points than this are painted as pixels. */
const MANY = 1000;

export function paintLayer(brush: Brush, content: LayerContent): void {
  (OVERLAYS[content.style] ?? PAINTERS[content.kind])(brush, content);
}

/** The column of a name; undefined where the layer has none. */
export function columnOf({ names, columns }: LayerContent, name: string): Float32Array | undefined {
  return columns[names.indexOf(name)];
}

/** From metres to CSS pixels: the place of the origin, and the pixels of a metre; y goes up in the one, down in the other. */
function lens({ view, size }: Brush): { readonly x0: number; readonly y0: number; readonly px: number } {
  const [x0, y0] = toScreen(view, size, 0, 0);
  return { x0, y0, px: 1 / view.scale };
}

/** From a value to its shade, 0 … SHADES - 1, even between the least and the greatest of them. */
export function shadesOf(values: Float32Array): Uint8Array {
  let low = Number.POSITIVE_INFINITY;
  let high = Number.NEGATIVE_INFINITY;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const shades = new Uint8Array(values.length);
  const scale = high > low ? (SHADES - 1) / (high - low) : 0;
  for (let i = 0; i < values.length; i++) shades[i] = Math.round(((values[i] as number) - low) * scale) || 0;
  return shades;
}

/** Do `paint` once for each shade that there is, in its colour; without values once, in the one colour of `plain`. */
function shaded(brush: Brush, values: Float32Array | null | undefined, plain: string, paint: Shade): void {
  if (!values) {
    paint(plain, () => true);
    return;
  }
  const shades = shadesOf(values);
  const present = new Uint8Array(SHADES);
  for (const shade of shades) present[shade] = 1;
  for (const [shade, colour] of brush.colours.shades.entries())
    if (present[shade]) paint(colour, (i) => shades[i] === shade);
}

type Shade = (colour: string, has: (i: number) => boolean) => void;

/** A dot at each point, coloured by its `value`, with an arrow where it has a `yaw`. */
const paintPoints: Overlay = (brush, content) => {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  if (!xs || !ys) return;
  const { ctx, size, colours } = brush;
  const { x0, y0, px } = lens(brush);
  const yaws = columnOf(content, "yaw");
  const every = Math.max(1, Math.ceil(xs.length / MAX_ARROWS));
  ctx.lineWidth = 1;
  if (xs.length > MANY && paintMany(brush, content, every)) return;
  shaded(brush, columnOf(content, "value"), colours.robot, (colour, has) => {
    ctx.fillStyle = ctx.strokeStyle = colour;
    ctx.beginPath();
    for (let i = 0; i < xs.length; i++) {
      if (!has(i)) continue;
      const x = x0 + px * (xs[i] as number);
      const y = y0 - px * (ys[i] as number);
      if (!(x >= 0 && y >= 0 && x <= size.width && y <= size.height)) continue; // outside, or no value
      ctx.fillRect(x - DOT_PX / 2, y - DOT_PX / 2, DOT_PX, DOT_PX);
      if (!yaws || i % every !== 0) continue;
      ctx.moveTo(x, y);
      ctx.lineTo(x + ARROW_PX * Math.cos(yaws[i] as number), y - ARROW_PX * Math.sin(yaws[i] as number));
    }
    if (yaws) ctx.stroke();
  });
};

/** As `paintPoints`, for many points: the dots as pixels, then the arrows of some in one colour for each shade. */
function paintMany(brush: Brush, content: LayerContent, every: number): boolean {
  const { ctx, colours } = brush;
  const [x, y, yaws, value] = ["x", "y", "yaw", "value"].map((name) => columnOf(content, name));
  if (!x || !y) return false;
  const { x0, y0, px } = lens(brush);
  const xs = x.map((at) => x0 + px * at);
  const ys = y.map((at) => y0 - px * at);
  const shades = value ? shadesOf(value) : null;
  if (!paintDots(brush, xs, ys, shades, value ? colours.shades : plainOf(colours.robot), DOT_PX)) return false;
  if (!yaws) return true;
  const paths = new Map<string, Path2D>();
  for (let i = 0; i < xs.length; i += every) {
    const colour = shades ? (colours.shades[shades[i] as number] ?? colours.robot) : colours.robot;
    const [left, top] = [xs[i] as number, ys[i] as number];
    if (!(left >= 0 && top >= 0 && left <= brush.size.width && top <= brush.size.height)) continue;
    let path = paths.get(colour);
    if (!path) {
      path = new Path2D();
      paths.set(colour, path);
    }
    path.moveTo(left, top);
    path.lineTo(left + ARROW_PX * Math.cos(yaws[i] as number), top - ARROW_PX * Math.sin(yaws[i] as number));
  }
  for (const [colour, path] of paths) {
    ctx.strokeStyle = colour;
    ctx.stroke(path);
  }
  return true;
}

const plains = new Map<string, readonly string[]>();
const plainOf = (colour: string): readonly string[] => {
  const known = plains.get(colour) ?? [colour];
  plains.set(colour, known);
  return known;
};

/** A line through the points, with a gap where one has no value. */
const paintLine: Overlay = (brush, content) => {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  if (!xs || !ys) return;
  const { ctx, colours } = brush;
  const { x0, y0, px } = lens(brush);
  ctx.beginPath();
  let isDown = false;
  for (let i = 0; i < xs.length; i++) {
    const x = x0 + px * (xs[i] as number);
    const y = y0 - px * (ys[i] as number);
    const isPoint = !Number.isNaN(x + y);
    if (isPoint && isDown) ctx.lineTo(x, y);
    else if (isPoint) ctx.moveTo(x, y);
    isDown = isPoint;
  }
  ctx.lineWidth = 2;
  ctx.strokeStyle = colours.trail;
  ctx.stroke();
};

/** A line for each edge, coloured by its value, and a dot at each node. */
const paintGraph: Overlay = (brush, content) => {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  const { edges, values } = content;
  if (!xs || !ys || !edges) return;
  const { ctx, colours } = brush;
  const { x0, y0, px } = lens(brush);
  ctx.lineWidth = 1;
  shaded(brush, values, colours.trail, (colour, has) => {
    ctx.strokeStyle = colour;
    ctx.beginPath();
    for (let i = 0; i < edges.length / 2; i++) {
      if (!has(i)) continue;
      const [from, to] = [edges[2 * i] as number, edges[2 * i + 1] as number];
      ctx.moveTo(x0 + px * (xs[from] as number), y0 - px * (ys[from] as number));
      ctx.lineTo(x0 + px * (xs[to] as number), y0 - px * (ys[to] as number));
    }
    ctx.stroke();
  });
  paintPoints(brush, content);
};

const PAINTERS: Readonly<Record<LayerContent["kind"], Overlay>> = {
  points: paintPoints,
  path: paintLine,
  graph: paintGraph,
};
