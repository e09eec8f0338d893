/**
 * How two maps differ, as a byte a cell and as colours.
 *
 * The bytes are in the order of what must not be lost: the pyramid keeps the greatest of each square, so a difference in
 * one cell is seen at every zoom, the greatest one of those under a pixel; then what only one map has observed.
 */

import { logOddsAt, stateAt } from "../../grid/cellValues";
import { type Rgb, tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import type { CellState, Geometry } from "../../wire/protocol";
import type { Codes } from "./combinedMap";
import { PALETTE_ROWS, type Palette, plain } from "./palettes";

export const SAME = 1;
export const SAME_WALL = 2;
export const ONLY_A = 3;
export const ONLY_B = 4;
/** The least difference: from here on the bytes are, by turns, less and more occupied in b, ever more so. */
export const FIRST = 5;
const LEVELS = 125;

type Range = Pick<Geometry, "low" | "high">;

/** The greatest difference that two maps of these ranges can show. */
export const spanOf = (a: Range, b: Range): number => Math.max(a.high, b.high) - Math.min(a.low, b.low);

/** How strongly a difference is coloured, 0 … 1: its square root, so that small ones can be told from none. */
export const strengthOf = (difference: number, span: number): number =>
  Math.min(1, Math.sqrt(Math.abs(difference) / span));

/** The byte of a difference other than 0. */
function byteOf(difference: number, span: number): number {
  const level = Math.max(1, Math.round(LEVELS * strengthOf(difference, span)));
  return FIRST + 2 * (level - 1) + (difference > 0 ? 1 : 0);
}

/** For each pair of bytes what their difference, b − a, is drawn as. */
export function differenceCodes(a: Range, b: Range): Codes {
  const codes = new Uint8Array(65536);
  const span = spanOf(a, b);
  // In one range equal values have equal bytes; in two they are rounded apart, by up to half a step of each.
  const isOneRange = a.low === b.low && a.high === b.high;
  const rounding = (a.high - a.low + b.high - b.low) / 254 / 2;
  for (let i = 1; i < 256; i++) {
    codes[i << 8] = ONLY_A;
    codes[i] = ONLY_B;
    const isWall = stateAt(i, a) === "occupied";
    for (let j = 1; j < 256; j++) {
      const difference = logOddsAt(j, b) - logOddsAt(i, a);
      const isSame = isOneRange ? i === j : Math.abs(difference) <= rounding;
      const same = isWall && stateAt(j, b) === "occupied" ? SAME_WALL : SAME;
      codes[(i << 8) | j] = isSame ? same : byteOf(difference, span);
    }
  }
  return codes;
}

/** What a person wants to see marked: cells by their state in both maps, or those that only one has observed. */
export type Marked = { readonly a: CellState; readonly b: CellState } | "only a" | "only b";

/** For each pair of bytes whether it is marked: 255 or 0. */
export function markedCodes(a: Range, b: Range, marked: Marked): Codes {
  const codes = new Uint8Array(65536);
  const statesB = Array.from({ length: 256 }, (_, j) => stateAt(j, b));
  for (let i = 0; i < 256; i++) {
    const stateA = stateAt(i, a);
    for (let j = 0; j < 256; j++) {
      if (i === 0 && j === 0) continue; // cells unseen in both are the ground on which the rest is marked
      let is: boolean;
      if (marked === "only a") is = j === 0;
      else if (marked === "only b") is = i === 0;
      else is = stateA === marked.a && statesB[j] === marked.b;
      if (is) codes[(i << 8) | j] = 255;
    }
  }
  return codes;
}

interface DifferenceColours {
  readonly unobserved: Rgb;
  readonly less: Rgb;
  readonly none: Rgb;
  readonly more: Rgb;
  readonly wall: Rgb;
  readonly apart: Rgb;
}

export const differenceColours = (): DifferenceColours => ({
  unobserved: tokenRgb("--map-unobserved"),
  less: tokenRgb("--difference-less"),
  none: tokenRgb("--map-undecided"),
  more: tokenRgb("--difference-more"),
  wall: tokenRgb("--difference-wall"),
  apart: tokenRgb("--difference-apart"),
});

/** The colour of a difference of this strength. */
export function differenceColour(strength: number, isMore: boolean, colours: DifferenceColours): Rgb {
  return fromLab(mixed(toLab(colours.none), toLab(isMore ? colours.more : colours.less), strength));
}

/** 256 RGBA colours in four rows: falling stripes where only a has observed a cell, rising ones where only b has. */
export function differencePalette(colours: DifferenceColours): Uint8Array<ArrayBuffer> {
  const out = new Uint8Array(256 * 4 * PALETTE_ROWS);
  for (let row = 0; row < PALETTE_ROWS; row++) {
    const put = (byte: number, rgb: Rgb): void => out.set([...rgb, 255], 4 * (256 * row + byte));
    put(0, colours.unobserved);
    put(SAME, colours.none);
    put(SAME_WALL, colours.wall);
    put(ONLY_A, row & 1 ? colours.apart : colours.unobserved);
    put(ONLY_B, row & 2 ? colours.apart : colours.unobserved);
    for (let level = 1; level <= LEVELS; level++) {
      for (const isMore of [false, true]) {
        put(FIRST + 2 * (level - 1) + (isMore ? 1 : 0), differenceColour(level / LEVELS, isMore, colours));
      }
    }
  }
  return out;
}

export const DIFFERENCE: Palette = { key: "difference", colours: () => differencePalette(differenceColours()) };

/** What is marked in the colour of what one acts on, the rest behind a veil. */
export const MARKS: Palette = {
  key: "marks",
  colours: () => {
    const row = new Uint8Array(256 * 4);
    row.set([...tokenRgb("--map-unobserved"), 165], 0);
    row.set([...tokenRgb("--mark"), 255], 4 * 255);
    return plain(row);
  },
};
