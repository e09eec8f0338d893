/** The pose graph of a healed log, as the server tells of it, and what a place of the picture stands for. */

import { columnOf, type LayerContent } from "../../render/picture/overlays";
import type { TriedNear } from "../../wire/http";
import type { Point } from "../../wire/protocol";
import { CONTRADICTS, STRAINED } from "./poseGraph";

const REACH_PX = 10;
/** Edges of odometry are many, and are meant only from nearer. */
const NEAR_PX = 4;

function fromSegment(at: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay];
  const length = dx * dx + dy * dy;
  const along = length > 0 ? Math.max(0, Math.min(1, ((at[0] - ax) * dx + (at[1] - ay) * dy) / length)) : 0;
  return Math.hypot(at[0] - ax - along * dx, at[1] - ay - along * dy);
}

/** The number of the loop nearest to a place, at most a few pixels of `scale` metres away; null for none. */
export const loopAt = (content: LayerContent | null, at: Point, scale: number): number | null =>
  nearest(content, at, REACH_PX * scale, (value) => !Number.isNaN(value));

/** The number of the edge at a place: a loop, or else one of odometry. */
export const edgeAt = (content: LayerContent | null, at: Point, scale: number): number | null =>
  loopAt(content, at, scale) ?? nearest(content, at, NEAR_PX * scale, Number.isNaN);

/** The number of the nearest edge of a kind that its value tells, at most `reach` metres away. */
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
  const accepted = candidates.filter((one) => one.accepted).length;
  if (accepted > 0)
    return `The robot was here ${times}, and ${accepted} ${accepted === 1 ? "loop" : "loops"} closed near this place.`;
  if (candidates.length > 0)
    return `The robot was here ${times}; ${candidates.length} ${candidates.length === 1 ? "loop was" : "loops were"} tried near this place, and all were refused.`;
  if (visits.length === 1) return "The robot was here only once: there is nothing that a loop could join.";
  return `The robot was here ${times}, but no loop was tried: between the visits the way was too short, or the poses were too far apart.`;
}

/** A residual in words, so that it is not told by colour alone. */
export function residualLabel(residual: number): string {
  if (residual < STRAINED) return "fits";
  return residual < CONTRADICTS ? "strained" : "contradicts";
}
