/**
 * The pose graph of a log: odometry as a thin line, loops by their residuals in standard deviations.
 *
 * A loop that fits is thin, one that is strained is wider and dashed, one that contradicts the rest is widest and dotted:
 * the residual is not told by colour alone.
 */

import { columnOf, type LayerContent, OVERLAYS, type Overlay } from "../../render/picture/overlays";
import { SHADES } from "../../render/picture/pictureColours";
import { toScreen } from "../../render/view";
import { LOOP_CONTRADICTS, LOOP_STRAINED } from "../../wire/constants";
import type { TriedNear } from "../../wire/http";
import type { Point } from "../../wire/protocol";

/** Style of the layer. */
export const STYLE = "pose_graph";

const KINDS: readonly { least: number; width: number; dash: number[]; shade: number }[] = [
  { least: 0, width: 1.25, dash: [], shade: 0 },
  { least: LOOP_STRAINED, width: 2, dash: [6, 3], shade: Math.floor(SHADES / 2) },
  { least: LOOP_CONTRADICTS, width: 3, dash: [2, 3], shade: SHADES - 1 },
];

const paintPoseGraph: Overlay = (brush, content) => {
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

/** A loop within this distance of a place on the screen is selected. */
const REACH_PX = 10;
/** There are many edges of odometry, so they are selected only from a smaller distance. */
const NEAR_PX = 4;

function fromSegment(at: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay];
  const length = dx * dx + dy * dy;
  const along = length > 0 ? Math.max(0, Math.min(1, ((at[0] - ax) * dx + (at[1] - ay) * dy) / length)) : 0;
  return Math.hypot(at[0] - ax - along * dx, at[1] - ay - along * dy);
}

/** The number of the loop nearest to a place, within a few pixels of `scale` metres; null for none. */
export const loopAt = (content: LayerContent | null, at: Point, scale: number): number | null =>
  nearest(content, at, REACH_PX * scale, (value) => !Number.isNaN(value));

/** The number of the edge at a place: a loop, otherwise one of odometry. */
export const edgeAt = (content: LayerContent | null, at: Point, scale: number): number | null =>
  loopAt(content, at, scale) ?? nearest(content, at, NEAR_PX * scale, Number.isNaN);

/** The number of the nearest edge of a kind, determined by its value, at most `reach` metres away. */
function nearest(
  content: LayerContent | null,
  at: Point,
  reach: number,
  has: (value: number) => boolean,
): number | null {
  if (!content?.edges || !content.values) return null;
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  if (!xs || !ys) return null;
  let best: number | null = null;
  let least = reach;
  for (let edge = 0; edge < content.values.length; edge++) {
    if (!has(content.values[edge] as number)) continue;
    const [i, j] = [content.edges[2 * edge] as number, content.edges[2 * edge + 1] as number];
    const away = fromSegment(at, [xs[i] as number, ys[i] as number], [xs[j] as number, ys[j] as number]);
    if (away < least) {
      least = away;
      best = edge;
    }
  }
  return best;
}

/** Why no loop closed at a place, in one sentence. */
export function whyNone({ visits, candidates }: Pick<TriedNear, "visits" | "candidates">): string {
  if (visits.length === 0) return "The robot was never within 3 m of this place.";
  const times = ["never", "once", "twice"][visits.length] ?? `${visits.length} times`;
  const accepted = candidates.filter((candidate) => candidate.accepted).length;
  if (accepted > 0)
    return `The robot was here ${times}, and ${accepted} ${accepted === 1 ? "loop" : "loops"} closed near this place.`;
  if (candidates.length > 0)
    return `The robot was here ${times}; ${candidates.length} ${candidates.length === 1 ? "loop was" : "loops were"} tried near this place, and all were refused.`;
  if (visits.length === 1) return "The robot was here only once: there is nothing that a loop could join.";
  return `The robot was here ${times}, but no loop was tried: between the visits the way was too short, or the poses were too far apart.`;
}

/** A residual in words, so that it is not shown by colour alone. */
export function residualLabel(residual: number): string {
  if (residual < LOOP_STRAINED) return "fits";
  return residual < LOOP_CONTRADICTS ? "strained" : "contradicts";
}
