/** The true path of a simulated robot over its map: a dashed line, beside the believed one. */

import { columnOf, OVERLAYS, type Overlay } from "../../render/picture/overlays";
import { toScreen } from "../../render/view";

/** Style of the layer. */
export const STYLE = "true_path";
/** Metres between two scans: no drive is as fast, the robot was put elsewhere. */
const CARRIED = 2;

const paintTruePath: Overlay = ({ ctx, view, size, colours }, content) => {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  if (!xs || !ys) return;
  const [x0, y0] = toScreen(view, size, 0, 0);
  ctx.beginPath();
  let [lastX, lastY] = [Number.POSITIVE_INFINITY, 0];
  for (let i = 0; i < xs.length; i++) {
    const [x, y] = [xs[i] as number, ys[i] as number];
    const at = [x0 + x / view.scale, y0 - y / view.scale] as const;
    if (Math.hypot(x - lastX, y - lastY) < CARRIED) ctx.lineTo(...at);
    else ctx.moveTo(...at);
    [lastX, lastY] = [x, y];
  }
  for (const [width, colour, dash] of [
    [4, colours.halo, []],
    [2, colours.outline, [7, 5]],
  ] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.setLineDash([...dash]);
    ctx.stroke();
  }
  ctx.setLineDash([]);
};

OVERLAYS[STYLE] = paintTruePath;
