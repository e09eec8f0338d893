/** The layout of a tree of frames: one line per frame, children indented under their parent. */

import type { FrameEdgeAnswer } from "../../../wire/http";

export interface PlacedFrame {
  readonly name: string;
  readonly depth: number;
  /** The line, from 0. */
  readonly line: number;
  /** The edge to its parent, null for a root. */
  readonly edge: FrameEdgeAnswer | null;
  /** The line of its parent. */
  readonly parentLine: number | null;
}

/**
 * Place every frame: roots first in the order of their names, that of the fixed frame before the others. A frame of a
 * loop, which no root leads to, begins a tree of its own.
 */
export function placedFrames(
  names: readonly string[],
  edges: readonly FrameEdgeAnswer[],
  fixed: string,
): PlacedFrame[] {
  const used = edges.filter((edge) => edge.used);
  const edgeOf = new Map(used.map((edge) => [edge.child, edge]));
  const children = new Map<string, FrameEdgeAnswer[]>();
  for (const edge of used) children.set(edge.parent, [...(children.get(edge.parent) ?? []), edge]);
  const placed: PlacedFrame[] = [];
  const seen = new Set<string>();
  const place = (name: string, depth: number, edge: FrameEdgeAnswer | null, parentLine: number | null): void => {
    if (seen.has(name)) return;
    seen.add(name);
    const line = placed.length;
    placed.push({ name, depth, line, edge, parentLine });
    for (const one of children.get(name) ?? []) place(one.child, depth + 1, one, line);
  };
  const rootOf = (name: string): string => {
    const passed = new Set<string>();
    let at = name;
    while (!passed.has(at)) {
      passed.add(at);
      at = edgeOf.get(at)?.parent ?? at;
    }
    return at;
  };
  place(rootOf(fixed), 0, null, null);
  for (const name of names) if (!edgeOf.has(name)) place(name, 0, null, null);
  for (const name of names) place(name, 0, null, null);
  return placed;
}

/** Whether a transform is older than two of its usual pauses, and more than 0.2 s. */
export function isLate({ static: isStatic, age_s: age, rate_hz: rate }: FrameEdgeAnswer): boolean {
  if (isStatic) return false;
  return age === null || age > Math.max(0.2, rate === null ? 1 : 2 / rate);
}
