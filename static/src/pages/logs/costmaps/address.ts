/** The address of a view of recorded costmaps: which costmap of which topic, and the visible part of the world. */

import type { View } from "../../../render/view";

interface CostmapView {
  readonly topic: string;
  /** The number of the costmap, 1 for the first. */
  readonly index: number;
  /** The visible part of the world; null: all of it. */
  readonly view: View | null;
}

/** A view as the fragment of an address. */
export function fragmentOf({ topic, index, view }: CostmapView): string {
  const query = new URLSearchParams({ costmap: String(index), topic });
  if (view) for (const [name, value] of Object.entries(view)) query.set(name, String(Number(value.toPrecision(6))));
  return `#${query}`;
}

/** The view in the fragment of an address; null where it has none. */
export function viewOf(fragment: string): CostmapView | null {
  const query = new URLSearchParams(fragment.slice(1));
  const index = Number(query.get("costmap"));
  const topic = query.get("topic");
  if (!Number.isInteger(index) || index < 1 || !topic) return null;
  const [x = Number.NaN, y = Number.NaN, scale = Number.NaN] = ["x", "y", "scale"].map((name) => {
    const text = query.get(name);
    return text ? Number(text) : Number.NaN;
  });
  const isView = Number.isFinite(x) && Number.isFinite(y) && Number.isFinite(scale) && scale > 0;
  return { topic, index, view: isView ? { x, y, scale } : null };
}
