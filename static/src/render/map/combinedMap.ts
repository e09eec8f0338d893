/** A map computed from two others cell by cell, as their difference or their sum. */

import { logOddsAt, shownByteAt } from "../../grid/cellValues";
import { LATTICE_TOLERANCE } from "../../wire/constants";
import { type Geometry, TILE, type Values } from "../../wire/protocol";
import { Cells } from "./cells";

type Range = Pick<Geometry, "low" | "high">;

/**
 * For each pair of bytes the byte, in the range of b, of their sum ℓ_a + ℓ_b − ℓ₀, as mapper/grid/merge.py adds them;
 * what only one map has observed stays what it is.
 */
export function mergedCodes(a: Range, b: Range, prior: number): Codes {
  const codes = new Uint8Array(65536);
  const byteOf = (logOdds: number): number => Math.round(shownByteAt(logOdds, b));
  for (let j = 1; j < 256; j++) codes[j] = j;
  for (let i = 1; i < 256; i++) {
    const valueA = logOddsAt(i, a);
    codes[i << 8] = byteOf(valueA);
    for (let j = 1; j < 256; j++) codes[(i << 8) | j] = byteOf(valueA + logOddsAt(j, b) - prior);
  }
  return codes;
}

/** A lattice that contains two maps, and the offset of each in tiles from its cell (0, 0). */
export interface CommonLattice {
  readonly geometry: Geometry;
  readonly a: readonly [ty: number, tx: number];
  readonly b: readonly [ty: number, tx: number];
}

/**
 * The lattice that contains two maps; null if their cells do not coincide. Maps of one resolution are whole tiles apart
 * (`GridGeometry.covering` of mapper/grid/occupancy_grid.py).
 */
export function commonLattice(a: Geometry, b: Geometry): CommonLattice | null {
  const size = b.resolution;
  if (Math.abs(a.resolution / size - 1) * Math.max(a.rows, a.cols) > LATTICE_TOLERANCE) return null;
  if (a.origin[2] !== 0 || b.origin[2] !== 0) return null;
  const apart = [1, 0].map((axis) => ((a.origin[axis] as number) - (b.origin[axis] as number)) / (size * TILE));
  const [ty, tx] = apart.map(Math.round) as [number, number];
  if (
    Math.abs((apart[0] as number) - ty) * TILE > LATTICE_TOLERANCE ||
    Math.abs((apart[1] as number) - tx) * TILE > LATTICE_TOLERANCE
  )
    return null;
  const bottom = Math.min(0, ty);
  const left = Math.min(0, tx);
  const rows = Math.max(b.rows, ty * TILE + a.rows) - bottom * TILE;
  const cols = Math.max(b.cols, tx * TILE + a.cols) - left * TILE;
  const origin = [b.origin[0] + left * TILE * size, b.origin[1] + bottom * TILE * size, 0] as const;
  return { geometry: { ...b, rows, cols, origin }, a: [ty - bottom, tx - left], b: [0 - bottom, 0 - left] };
}

/** The byte for each pair of bytes; the index is 256 · (byte of `a`) + (byte of `b`). */
export type Codes = Uint8Array;

const bytesA = new Uint8Array(TILE * TILE);
const bytesB = new Uint8Array(TILE * TILE);
const made = new Uint8Array(TILE * TILE);

export class CombinedMap {
  readonly cells = new Cells();
  readonly #a: Cells;
  readonly #b: Cells;
  readonly #lattice: CommonLattice;
  readonly #codes: Codes;
  /** Tiles that changed since they were last computed, as ty · 65536 + tx of the common lattice. */
  readonly #stale = new Set<number>();
  readonly #onTileA: (tx: number, ty: number) => void;
  readonly #onTileB: (tx: number, ty: number) => void;

  constructor(a: Cells, b: Cells, lattice: CommonLattice, codes: Codes) {
    this.#a = a;
    this.#b = b;
    this.#lattice = lattice;
    this.#codes = codes;
    const markStale =
      ([y, x]: readonly [number, number]) =>
      (tx: number, ty: number): void =>
        void this.#stale.add((ty + y) * 65536 + tx + x);
    this.#onTileA = markStale(lattice.a);
    this.#onTileB = markStale(lattice.b);
    a.listeners.add(this.#onTileA);
    b.listeners.add(this.#onTileB);
    const { rows, cols } = lattice.geometry;
    for (let ty = 0; ty < rows / TILE; ty++) for (let tx = 0; tx < cols / TILE; tx++) this.#stale.add(ty * 65536 + tx);
  }

  /** Bring the cells up to date; returns them. */
  update(): Cells {
    for (const key of this.#stale) this.#make(key >> 16, key & 0xffff);
    this.#stale.clear();
    return this.cells;
  }

  #make(ty: number, tx: number): void {
    const { a, b } = this.#lattice;
    const hasA = this.#a.readTile(tx - a[1], ty - a[0], bytesA);
    const hasB = this.#b.readTile(tx - b[1], ty - b[0], bytesB);
    if (!hasA && !hasB) return;
    if (!hasA) bytesA.fill(0);
    if (!hasB) bytesB.fill(0);
    for (let i = 0; i < made.length; i++) {
      // int8 as on the wire
      made[i] = (this.#codes[((bytesA[i] as number) << 8) | (bytesB[i] as number)] as number) ^ 0x80;
    }
    this.cells.setTile(tx, ty, made);
  }

  dispose(): void {
    this.#a.listeners.delete(this.#onTileA);
    this.#b.listeners.delete(this.#onTileB);
  }
}

/** Models whose maps are not sums of log-odds: they store counts or two certainties for each cell. */
const NOT_ADDITIVE: readonly unknown[] = ["hit_counting", "moravec_elfes"];

/** Why the maps with the settings of A and of B cannot be merged, as `merged` in mapper/grid/merge.py; null if they can. */
export function whyNoMerge(a: Values, b: Values): string | null {
  if (NOT_ADDITIVE.includes(a.model) || NOT_ADDITIVE.includes(b.model))
    return "Maps of hit counting and of Moravec and Elfes are not sums of log-odds and cannot be added.";
  return a.log_odds_prior === b.log_odds_prior ? null : "A and B have different priors and cannot be added.";
}
