/** Cells that are only in the 3D map, drawn over the belief. */

import { PALETTES, type Palette, plain } from "../../render/map/palettes";
import type { Layer } from "../../render/map/renderer";
import type { Store } from "../../store/store";
import { tokenRgb } from "../../style/colour";

/** Name and style of the layer. */
export const ONLY_IN_3D = "only_in_3d";
/** Byte of a cell that is occupied in the 3D map's projection, and free or unknown in the belief. */
const MISSING_BYTE = 3;

const OVER: Palette = {
  key: "only in 3d",
  colours: () => {
    const row = new Uint8Array(256 * 4);
    row.set([...tokenRgb("--cost-inscribed"), 235], MISSING_BYTE * 4);
    return plain(row);
  },
};

PALETTES[ONLY_IN_3D] = () => OVER;

export function map3dOver(store: Store): readonly Layer[] {
  const map = store.part("map3d").isOver.peek() ? store.layers.grid(ONLY_IN_3D).map.peek() : null;
  return map ? [{ map, palette: OVER, blends: true }] : [];
}

/** Read every signal that is painted here. */
export function watchMap3d(store: Store): void {
  if (store.part("map3d").isOver.value) void store.layers.grid(ONLY_IN_3D).version.value;
}
