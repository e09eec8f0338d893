/**
 * The max-occupancy pyramid: how a map looks from afar.
 *
 * A stored cell is a byte: 0 is "never observed", 1 … 255 are the wire's −127 … 127, the least to the greatest log-odds.
 * A texel of level n + 1 is the greatest of the 2 × 2 texels of level n under it. So occupied wins over undecided,
 * undecided over free, and anything observed over what was never observed: a wall one cell thick stays a wall at every
 * zoom, and free space stays open only where no part of it is occupied. Nothing is averaged: a colour on the screen
 * is always the belief about some cell.
 */

/** Cells along the side of a chunk, the unit of storage and of textures: 8 × 8 tiles. */
export const CHUNK = 512;
/** Levels of a chunk's pyramid: 512, 256, … 1. */
export const LEVELS = 10;

/** Side of a chunk at a level, in texels. */
export const sideOf = (level: number): number => CHUNK >> level;

/** The level at which a texel covers at least one pixel, so that none is skipped: 0 when a cell is a pixel or more. */
export function levelFor(pixelsPerCell: number): number {
  return Math.min(LEVELS - 1, Math.max(0, Math.ceil(-Math.log2(pixelsPerCell) - 1e-9)));
}

/** A chunk: its pyramid, level by level. */
export type Pyramid = readonly Uint8Array[];

export function emptyPyramid(): Pyramid {
  return Array.from({ length: LEVELS }, (_, level) => new Uint8Array(sideOf(level) ** 2));
}

/** Re-make the levels above the cells [row, row + side) × [col, col + side); all three are multiples of a tile. */
export function reduce(pyramid: Pyramid, row: number, col: number, side: number): void {
  let r0 = row;
  let c0 = col;
  let n = side;
  for (let level = 1; level < LEVELS; level++) {
    r0 >>= 1;
    c0 >>= 1;
    n = Math.max(1, n >> 1);
    reduceBox(pyramid[level - 1] as Uint8Array, pyramid[level] as Uint8Array, sideOf(level), r0, c0, n);
  }
}

function reduceBox(from: Uint8Array, to: Uint8Array, side: number, r0: number, c0: number, n: number): void {
  const wide = 2 * side;
  for (let r = r0; r < r0 + n; r++) {
    let at = 2 * r * wide + 2 * c0;
    for (let c = c0; c < c0 + n; c++, at += 2) {
      const upper = Math.max(from[at + wide] as number, from[at + wide + 1] as number);
      to[r * side + c] = Math.max(from[at] as number, from[at + 1] as number, upper);
    }
  }
}
