/**
 * A complete example of the pages' side of a session kind in one file: its name, the palette of its grid and the
 * painter of its points. The server's side is `tests/server/sessions/waves_kind.py`.
 */

import { PALETTES, type Palette, plain } from "../../render/map/palettes";
import { columnOf, OVERLAYS, type Overlay } from "../../render/picture/overlays";
import { toScreen } from "../../render/view";
import { KINDS } from "../../wire/kinds";

/** From dark blue, the lowest, to white, the highest; byte 0 is a cell without a value. */
const HEIGHT: Palette = {
  key: "height",
  colours: () => {
    const row = new Uint8Array(256 * 4);
    row.set([128, 128, 128, 255]);
    for (let byte = 1; byte < 256; byte++) row.set([byte, byte, 128 + (byte >> 1), 255], 4 * byte);
    return plain(row);
  },
};

const RADIUS_PX = 6;
/** Pixels by which a float is drawn higher for each metre of its height. */
const LIFT_PX = 8;

/** A red disc for each float, drawn higher on the screen where the water is higher. */
const paintFloats: Overlay = ({ ctx, view, size }, content) => {
  const [xs, ys, heights] = ["x", "y", "value"].map((name) => columnOf(content, name));
  if (!xs || !ys || !heights) return;
  ctx.fillStyle = "#c0392b";
  for (const [i, height] of heights.entries()) {
    const [x, y] = toScreen(view, size, xs[i] as number, ys[i] as number);
    ctx.beginPath();
    ctx.arc(x, y - LIFT_PX * height, RADIUS_PX, 0, 2 * Math.PI);
    ctx.fill();
  }
};

/** Register this kind in the pages. */
export function registerWaves(): void {
  KINDS.waves = { isDriven: false, hasRobot: false };
  PALETTES.height = () => HEIGHT;
  OVERLAYS.floats = paintFloats;
}
