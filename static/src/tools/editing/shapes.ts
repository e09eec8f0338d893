/** The shapes that the editing tools draw into a world, and the solids that they erase. */

import { WALL_THICKNESS } from "../../wire/constants";
import type { DrawnSolid, Edits, Point, WorldMessage } from "../../wire/protocol";

/** Corners are at multiples of this, metres. */
const SNAP = 0.05;
/** A wall closer than this to vertical or horizontal is aligned, radians. */
const STRAIGHT = 0.09;
/** A stroke shorter than this is ignored as unintentional, metres. */
const LEAST = 0.1;

const centimetres = (metres: number): number => Math.round(metres / SNAP) * Math.round(SNAP * 100);

/** The solid drawn by a stroke from one place to another; null if it is too short or too thin. */
export function shapeOfStroke(kind: "wall" | "box", from: Point, to: Point): DrawnSolid | null {
  let [x, y] = to;
  const dx = x - from[0];
  const dy = y - from[1];
  if (kind === "wall") {
    if (Math.abs(dy) < Math.abs(dx) * Math.tan(STRAIGHT)) y = from[1];
    else if (Math.abs(dx) < Math.abs(dy) * Math.tan(STRAIGHT)) x = from[0];
  }
  const made: DrawnSolid = [kind, ...[from[0], from[1], x, y].map(centimetres)] as unknown as DrawnSolid;
  const width = Math.abs(made[3] - made[1]) / 100;
  const height = Math.abs(made[4] - made[2]) / 100;
  return (kind === "wall" ? Math.hypot(width, height) : Math.min(width, height)) < LEAST ? null : made;
}

/** The outline of the drawn solid, as in mapper/simulation/edits.py. */
export function outline([kind, ...corners]: DrawnSolid): readonly Point[] {
  const [x0, y0, x1, y1] = corners.map((value) => value / 100) as [number, number, number, number];
  if (kind === "box") {
    return [
      [x0, y0],
      [x1, y0],
      [x1, y1],
      [x0, y1],
    ];
  }
  const length = Math.hypot(x1 - x0, y1 - y0);
  const nx = (-(y1 - y0) / length) * (WALL_THICKNESS / 2);
  const ny = ((x1 - x0) / length) * (WALL_THICKNESS / 2);
  return [
    [x0 - nx, y0 - ny],
    [x1 - nx, y1 - ny],
    [x1 + nx, y1 + ny],
    [x0 + nx, y0 + ny],
  ];
}

/** The stroke inside the world's bounds. */
export function clampedToWorld(point: Point, [x0, y0, x1, y1]: WorldMessage["bounds"], margin = WALL_THICKNESS): Point {
  return [
    Math.min(x1 - margin, Math.max(x0 + margin, point[0])),
    Math.min(y1 - margin, Math.max(y0 + margin, point[1])),
  ];
}

function inside(polygon: readonly Point[], [x, y]: Point): boolean {
  let odd = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [ax, ay] = polygon[i] as Point;
    const [bx, by] = polygon[j] as Point;
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) odd = !odd;
  }
  return odd;
}

function distance(polygon: readonly Point[], [x, y]: Point): number {
  let best = Number.POSITIVE_INFINITY;
  for (let i = 0; i < polygon.length; i++) {
    const [ax, ay] = polygon[i] as Point;
    const [bx, by] = polygon[(i + 1) % polygon.length] as Point;
    const length2 = (bx - ax) ** 2 + (by - ay) ** 2;
    const t = length2 === 0 ? 0 : Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length2));
    best = Math.min(best, Math.hypot(x - ax - t * (bx - ax), y - ay - t * (by - ay)));
  }
  return best;
}

/** Whether a solid is part of the outer wall, which must not be erased. */
function isOuter(polygon: readonly Point[], [x0, y0, x1, y1]: WorldMessage["bounds"]): boolean {
  const near = (a: number, b: number): boolean => Math.abs(a - b) < 1e-3;
  return polygon.some(([x, y]) => near(x, x0) || near(x, x1) || near(y, y0) || near(y, y1));
}

/** The polygon of the world that a place selects: one that contains it, or the nearest within `reach` metres. */
export function solidAt(world: WorldMessage, point: Point, reach: number): number | null {
  let best: number | null = null;
  let least = reach;
  for (const [i, polygon] of world.polygons.entries()) {
    if (isOuter(polygon, world.bounds)) continue;
    const away = inside(polygon, point) ? 0 : distance(polygon, point);
    if (away <= least) {
      best = i;
      least = away;
    }
  }
  return best;
}

/** The edits that remove a polygon from the current world. */
export function editsWithout(world: WorldMessage, polygon: number): Edits {
  const id = world.ids[polygon];
  const { added, erased } = world.edits;
  if (id === undefined) return world.edits;
  if (id < 0) return { added: added.filter((_, i) => i !== -1 - id), erased };
  return { added, erased: [...erased, id].sort((a, b) => a - b) };
}
