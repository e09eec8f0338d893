/** Many dots of a few colours: written as pixels into memory, and painted in one pass. */

import type { Brush } from "./brush";

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
export function paintDots(
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
