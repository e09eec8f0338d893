/** A map made of two others, cell by cell: how they differ, or where something holds of both. */

import { LATTICE_TOLERANCE } from "../../wire/constants";
import { type Geometry, TILE } from "../../wire/protocol";
import { Cells } from "./cells";

/** Where two maps lie on the lattice that holds both; a place in tiles from its cell (0, 0). */
export interface CommonLattice {
  readonly geometry: Geometry;
  readonly a: readonly [ty: number, tx: number];
  readonly b: readonly [ty: number, tx: number];
}

/**
 * The lattice that holds two maps; null where their cells do not coincide. Maps of one resolution are whole tiles apart
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

/** What stands for a pair of bytes: of `a` in the upper half of the index, of `b` in the lower. */
export type Codes = Uint8Array;

const bytesA = new Uint8Array(TILE * TILE);
const bytesB = new Uint8Array(TILE * TILE);
const made = new Uint8Array(TILE * TILE);

export class Derived {
  readonly cells = new Cells();
  readonly #a: Cells;
  readonly #b: Cells;
  readonly #place: CommonLattice;
  readonly #codes: Codes;
  /** Tiles that have changed since they were last made, as ty · 65536 + tx of the common lattice. */
  readonly #stale = new Set<number>();
  readonly #hearA: (tx: number, ty: number) => void;
  readonly #hearB: (tx: number, ty: number) => void;

  constructor(a: Cells, b: Cells, place: CommonLattice, codes: Codes) {
    this.#a = a;
    this.#b = b;
    this.#place = place;
    this.#codes = codes;
    const hear =
      ([y, x]: readonly [number, number]) =>
      (tx: number, ty: number): void =>
        void this.#stale.add((ty + y) * 65536 + tx + x);
    this.#hearA = hear(place.a);
    this.#hearB = hear(place.b);
    a.listeners.add(this.#hearA);
    b.listeners.add(this.#hearB);
    const { rows, cols } = place.geometry;
    for (let ty = 0; ty < rows / TILE; ty++) for (let tx = 0; tx < cols / TILE; tx++) this.#stale.add(ty * 65536 + tx);
  }

  /** Bring the cells up to date; returns them. */
  update(): Cells {
    for (const key of this.#stale) this.#make(key >> 16, key & 0xffff);
    this.#stale.clear();
    return this.cells;
  }

  #make(ty: number, tx: number): void {
    const { a, b } = this.#place;
    const hasA = this.#a.readTile(tx - a[1], ty - a[0], bytesA);
    const hasB = this.#b.readTile(tx - b[1], ty - b[0], bytesB);
    if (!hasA && !hasB) return;
    if (!hasA) bytesA.fill(0);
    if (!hasB) bytesB.fill(0);
    for (let i = 0; i < made.length; i++) {
      // As the wire has it: int8.
      made[i] = (this.#codes[((bytesA[i] as number) << 8) | (bytesB[i] as number)] as number) ^ 0x80;
    }
    this.cells.setTile(tx, ty, made);
  }

  dispose(): void {
    this.#a.listeners.delete(this.#hearA);
    this.#b.listeners.delete(this.#hearB);
  }
}
