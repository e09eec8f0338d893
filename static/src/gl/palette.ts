/** From a cell's byte to its colour: a ramp for each side of log-odds 0, even to the eye (steps of OKLab). */

import { byteAt } from "../belief";
import type { Geometry } from "../protocol";
import { type Rgb, tokenRgb } from "../style/colour";

type Lab = readonly [l: number, a: number, b: number];

const linear = (byte: number): number => {
  const c = byte / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
};
const gamma = (c: number): number => {
  const v = c <= 0.0031308 ? 12.92 * c : 1.055 * Math.max(0, c) ** (1 / 2.4) - 0.055;
  return Math.round(255 * Math.min(1, Math.max(0, v)));
};

/** sRGB bytes to OKLab. Source: Björn Ottosson, A perceptual color space for image processing, 2020. */
export function toLab([red, green, blue]: Rgb): Lab {
  const r = linear(red);
  const g = linear(green);
  const b = linear(blue);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

/** OKLab to sRGB bytes; colours that a screen lacks are cut. */
export function fromLab([L, A, B]: Lab): Rgb {
  const l = (L + 0.3963377774 * A + 0.2158037573 * B) ** 3;
  const m = (L - 0.1055613458 * A - 0.0638541728 * B) ** 3;
  const s = (L - 0.0894841775 * A - 1.291485548 * B) ** 3;
  return [
    gamma(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    gamma(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    gamma(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

export const mixed = (a: Lab, b: Lab, t: number): Lab => [
  a[0] + (b[0] - a[0]) * t,
  a[1] + (b[1] - a[1]) * t,
  a[2] + (b[2] - a[2]) * t,
];

export interface MapColours {
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
export const beliefPalette = (range: Pick<Geometry, "log_odds_min" | "log_odds_max">): Palette => ({
  key: `belief ${range.log_odds_min} ${range.log_odds_max}`,
  colours: () => plain(palette(range, mapColours())),
});

/** 256 RGBA colours: byte 0 is never observed; free at the lower end, undecided at log-odds 0, occupied at the upper. */
export function palette(
  range: Pick<Geometry, "log_odds_min" | "log_odds_max">,
  colours: MapColours,
): Uint8Array<ArrayBuffer> {
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
