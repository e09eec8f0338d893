/** From a cell's byte to its colour: a ramp for each side of log-odds 0, even to the eye (steps of OKLab). */

import { byteAt } from "../../grid/cellValues";
import { type Rgb, tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import type { Geometry } from "../../wire/protocol";

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
export const beliefPalette = (range: Pick<Geometry, "low" | "high">): Palette => ({
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
