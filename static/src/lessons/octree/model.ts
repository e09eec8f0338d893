/**
 * The floor of the stage in three dimensions as an octree: leaves are occupied or free, and eight children of one state
 * are one node. Unknown space has no nodes.
 *
 * Source: Hornung et al. 2013, OctoMap. Metres, x right, y up on the stage, z above the floor.
 */

import type { Wall } from "../common/world";
import { LOW_TABLE, LOW_TABLE_HEIGHT, POLISHED, TABLE, WALLS } from "../stage/floor";

export type State = "free" | "occupied";
type Box = readonly [x0: number, y0: number, z0: number, x1: number, y1: number, z1: number];

/** Side of the root's cube; the finest cells are a 2ⁿ-th of it. */
const ROOT = 12.8;
export const CEILING = 2.6;
const THICK = 0.1;
const LINTEL = 2;
const CUPBOARD = 1.8;
/** What is inside the building: free where nothing stands. */
const INSIDE: Box = [0.435, 0.435, 0, 11.535, 7.535, CEILING];

const around = (walls: readonly Wall[], top: number): Box => {
  const xs = walls.flatMap(([x0, , x1]) => [x0, x1]);
  const ys = walls.flatMap(([, y0, , y1]) => [y0, y1]);
  return [Math.min(...xs), Math.min(...ys), 0, Math.max(...xs), Math.max(...ys), top];
};
const thick = ([x0, y0, x1, y1]: Wall, bottom = 0): Box => [
  Math.min(x0, x1) - THICK / 2,
  Math.min(y0, y1) - THICK / 2,
  bottom,
  Math.max(x0, x1) + THICK / 2,
  Math.max(y0, y1) + THICK / 2,
  CEILING,
];

/** Everything solid: walls up to the ceiling, lintels over the two doors, the cupboard, and the low table. */
const SOLIDS: readonly Box[] = [
  ...[...WALLS, POLISHED].map((wall) => thick(wall)),
  thick([1.835, 3.235, 3.135, 3.235], LINTEL),
  thick([7.135, 3.235, 8.335, 3.235], LINTEL),
  around(TABLE, CUPBOARD),
  around(LOW_TABLE, LOW_TABLE_HEIGHT),
];

const touches = (a: Box, b: Box): boolean =>
  a[0] < b[3] && b[0] < a[3] && a[1] < b[4] && b[1] < a[4] && a[2] < b[5] && b[2] < a[5];
const contains = (a: Box, b: Box): boolean =>
  a[0] <= b[0] && a[1] <= b[1] && a[2] <= b[2] && a[3] >= b[3] && a[4] >= b[4] && a[5] >= b[5];

/** The state of a finest cell: occupied where it touches something solid, unknown (null) where not wholly inside. */
export function stateOf(cell: Box, solids: readonly Box[] = SOLIDS): State | null {
  if (solids.some((solid) => touches(solid, cell))) return "occupied";
  return contains(INSIDE, cell) ? "free" : null;
}

export const cube = (x: number, y: number, z: number, side: number): Box => [x, y, z, x + side, y + side, z + side];

/** A leaf that a horizontal plane cuts. */
interface Leaf {
  readonly x: number;
  readonly y: number;
  readonly side: number;
  readonly state: State;
}

export interface Tree {
  readonly leaves: number;
  readonly inner: number;
  readonly slice: readonly Leaf[];
}

/** An octree: the leaves with their lower faces, and the number of inner nodes. */
interface Grown {
  readonly leaves: readonly (Leaf & { readonly z: number })[];
  readonly inner: number;
}

/** The octree with finest cells of `resolution`. */
export function grown(resolution: number): Grown {
  let inner = 0;
  const leaves: (Leaf & { readonly z: number })[] = [];
  /** Count a node; its state if it is a leaf, null for no node at all, "mixed" for an inner one. */
  const visit = (x: number, y: number, z: number, side: number, near: readonly Box[]): State | null | "mixed" => {
    const here = cube(x, y, z, side);
    const solids = near.filter((solid) => touches(solid, here));
    if (side < 1.5 * resolution) return stateOf(here, solids);
    if (solids.length === 0 && contains(INSIDE, here)) return "free";
    if (solids.length === 0 && !touches(INSIDE, here)) return null;
    const half = side / 2;
    const children = Array.from({ length: 8 }, (_, k) => {
      const at = [x + (k & 1) * half, y + ((k >> 1) & 1) * half, z + (k >> 2) * half] as const;
      return { at, state: visit(...at, half, solids) };
    });
    const [first] = children;
    if (children.every(({ state }) => state === first?.state) && first?.state !== "mixed") return first?.state ?? null;
    inner++;
    for (const { at, state } of children) if (state === "free" || state === "occupied") leaf(at, half, state);
    return "mixed";
  };
  const leaf = ([x, y, z]: readonly [number, number, number], side: number, state: State): void => {
    leaves.push({ x, y, z, side, state });
  };
  visit(0, 0, 0, ROOT, SOLIDS);
  return { leaves, inner };
}

/** An octree cut at a height. */
export const cut = ({ leaves, inner }: Grown, height: number): Tree => ({
  leaves: leaves.length,
  inner,
  slice: leaves.filter(({ z, side }) => z <= height && height < z + side),
});

/** Cells of a dense grid over the building. */
export const denseCells = (resolution: number): number =>
  Math.ceil(12 / resolution) * Math.ceil(8 / resolution) * Math.ceil(CEILING / resolution);

/** Bytes: a value of float32 for a cell; a node has a value and a pointer to its children, and eight pointers to them. */
export const BYTES = { cell: 4, leaf: 16, inner: 16 + 64, point: 12 } as const;
export const treeBytes = ({ leaves, inner }: Tree): number => leaves * BYTES.leaf + inner * BYTES.inner;
/** Points of a drive of 77 scans with 16 rings of 240 beams. */
export const POINTS = 77 * 16 * 240;
