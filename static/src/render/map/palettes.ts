/**
 * The palettes of grids by the style of their layer: from a cell's byte to its colour. That of a belief is a ramp for
 * each side of log-odds 0, even to the eye (steps of OKLab).
 */

import { byteAt } from "../../grid/cellValues";
import { type Rgb, tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import type { Geometry } from "../../wire/protocol";
import type { MapPicture } from "./mapPicture";

interface MapColours {
  readonly unobserved: Rgb;
  readonly free: Rgb;
  readonly undecided: Rgb;
  readonly occupied: Rgb;
}

export const mapColours = (): MapColours => ({
  unobserved: tokenRgb("--map-unobserved"),
  free: tokenRgb("--map-free"),
  undecided: tokenRgb("--map-undecided"),
  occupied: tokenRgb("--map-occupied"),
});

/** The colours of all bytes, for {@link PALETTE_ROWS} rows of stripes. Palettes of the same key are the same. */
export interface Palette {
  readonly key: string;
  readonly colours: () => Uint8Array<ArrayBuffer>;
}

/** Whether a pixel lies in a falling stripe, and twice that in a rising one: as the shader has it. */
export const PALETTE_ROWS = 4;

/** A row of colours as all rows: without stripes. */
export function plain(row: Uint8Array): Uint8Array<ArrayBuffer> {
  const out = new Uint8Array(row.length * PALETTE_ROWS);
  for (let i = 0; i < PALETTE_ROWS; i++) out.set(row, i * row.length);
  return out;
}

/** The colours of a belief. */
const beliefPalette = (range: Pick<Geometry, "low" | "high">): Palette => ({
  key: `belief ${range.low} ${range.high}`,
  colours: () => plain(palette(range, mapColours())),
});

/** 256 RGBA colours: byte 0 is never observed; free at the lower end, undecided at log-odds 0, occupied at the upper. */
export function palette(range: Pick<Geometry, "low" | "high">, colours: MapColours): Uint8Array<ArrayBuffer> {
  const free = toLab(colours.free);
  const undecided = toLab(colours.undecided);
  const occupied = toLab(colours.occupied);
  const zero = Math.min(255, Math.max(1, byteAt(0, range)));
  const out = new Uint8Array(256 * 4);
  out.set([...colours.unobserved, 255]);
  for (let byte = 1; byte < 256; byte++) {
    const lab =
      byte <= zero
        ? mixed(undecided, free, zero > 1 ? (zero - byte) / (zero - 1) : 0)
        : mixed(undecided, occupied, (byte - zero) / (255 - zero));
    out.set([...fromLab(lab), 255], byte * 4);
  }
  return out;
}

/** Makes the palette of a style for a range of values. */
type PaletteMaker = (range: Pick<Geometry, "low" | "high">) => Palette;

/** Values of which nothing is known but their order: from light to dark, byte 0 is a cell without one. */
const VALUES: Palette = {
  key: "values",
  colours: () => {
    const [low, high] = [toLab(tokenRgb("--map-free")), toLab(tokenRgb("--map-occupied"))];
    const row = new Uint8Array(256 * 4);
    row.set([...tokenRgb("--map-unobserved"), 255]);
    for (let byte = 1; byte < 256; byte++) row.set([...fromLab(mixed(low, high, (byte - 1) / 254)), 255], byte * 4);
    return plain(row);
  },
};

/** Costs 0 … 254 as bytes 1 … 255: free, rising, inscribed (253), lethal (254); byte 0 is no information. */
const RECORDED_COSTS: Palette = {
  key: "recorded_costs",
  colours: () => {
    const [low, high] = [toLab(tokenRgb("--cost-low")), toLab(tokenRgb("--cost-high"))];
    const row = new Uint8Array(256 * 4);
    const ends = ["--map-unobserved", "--map-free"] as const;
    for (const [byte, token] of ends.entries()) row.set([...tokenRgb(token), 255], byte * 4);
    for (let cost = 1; cost <= 252; cost++)
      row.set([...fromLab(mixed(low, high, (cost - 1) / 251)), 255], (cost + 1) * 4);
    row.set([...tokenRgb("--cost-inscribed"), 255], 254 * 4);
    row.set([...tokenRgb("--cost-lethal"), 255], 255 * 4);
    return plain(row);
  },
};

/** By style. A style that is not here is painted as `values`. */
export const PALETTES: Record<string, PaletteMaker> = {
  belief: beliefPalette,
  values: () => VALUES,
  recorded_costs: () => RECORDED_COSTS,
};

/** The palette with which a map is painted. */
export const paletteOf = ({ style, geometry }: MapPicture): Palette => (PALETTES[style] ?? (() => VALUES))(geometry);

/** Whether a grid is painted in the colours of occupied and free cells. */
export const hasMapColours = ({ style }: MapPicture): boolean => style === "belief";
