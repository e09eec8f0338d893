/** The palettes of grids by the style of their layer. */

import { tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import type { Geometry } from "../../wire/protocol";
import type { MapPicture } from "./mapPicture";
import { beliefPalette, type Palette, plain } from "./palette";

/** Makes the palette of a style for a range of values. */
export type PaletteMaker = (range: Pick<Geometry, "low" | "high">) => Palette;

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

/** By style. A style that is not here is painted as `values`. */
export const PALETTES: Record<string, PaletteMaker> = { belief: beliefPalette, values: () => VALUES };

/** The palette with which a map is painted. */
export const paletteOf = ({ style, geometry }: MapPicture): Palette => (PALETTES[style] ?? (() => VALUES))(geometry);
