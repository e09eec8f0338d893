/** The palettes of grids by the style of their layer. */

import { tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import type { Geometry } from "../../wire/protocol";
import type { MapPicture } from "./mapPicture";
import { beliefPalette, type Palette, plain } from "./palette";

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
