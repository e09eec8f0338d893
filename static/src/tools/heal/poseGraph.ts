/**
 * The pose graph of a log: odometry as a thin line, loops by their residuals in standard deviations.
 *
 * A loop that fits is thin, one that is strained is wider and dashed, one that contradicts the rest is widest and dotted:
 * the residual is not told by colour alone.
 */

import { columnOf, OVERLAYS, type Overlay } from "../../render/picture/overlays";
import { SHADES } from "../../render/picture/pictureColours";
import { toScreen } from "../../render/view";

/** Style of the layer. */
export const STYLE = "pose_graph";

/** Residuals from which a loop is strained, and from which it contradicts the rest; standard deviations. */
export const STRAINED = 2;
export const CONTRADICTS = 5;

const KINDS: readonly { least: number; width: number; dash: number[]; shade: number }[] = [
  { least: 0, width: 1.25, dash: [], shade: 0 },
  { least: STRAINED, width: 2, dash: [6, 3], shade: Math.floor(SHADES / 2) },
  { least: CONTRADICTS, width: 3, dash: [2, 3], shade: SHADES - 1 },
];

export const paintPoseGraph: Overlay = (brush, content) => {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  const { edges, values } = content;
  if (!xs || !ys || !edges || !values) return;
  const { ctx, view, size, colours } = brush;
  const [x0, y0] = toScreen(view, size, 0, 0);
  const trace = (has: (value: number) => boolean): void => {
    ctx.beginPath();
    for (let edge = 0; edge < values.length; edge++) {
      if (!has(values[edge] as number)) continue;
      const [from, to] = [edges[2 * edge] as number, edges[2 * edge + 1] as number];
      ctx.moveTo(x0 + (xs[from] as number) / view.scale, y0 - (ys[from] as number) / view.scale);
      ctx.lineTo(x0 + (xs[to] as number) / view.scale, y0 - (ys[to] as number) / view.scale);
    }
    ctx.stroke();
  };
  ctx.strokeStyle = colours.trail;
  ctx.lineWidth = 1;
  trace(Number.isNaN);
  for (const [n, { least, width, dash, shade }] of KINDS.entries()) {
    const below = KINDS[n + 1]?.least ?? Number.POSITIVE_INFINITY;
    ctx.strokeStyle = colours.shades[shade] ?? colours.trail;
    ctx.lineWidth = width;
    ctx.setLineDash(dash);
    trace((value) => value >= least && value < below);
  }
  ctx.setLineDash([]);
};

OVERLAYS[STYLE] = paintPoseGraph;
