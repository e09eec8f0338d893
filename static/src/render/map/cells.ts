/** The cells of one map in the browser: chunks with their pyramids, created when their first tile arrives. */

import { TILE } from "../../wire/protocol";
import { CHUNK, emptyPyramid, LEVELS, type Pyramid, reduce } from "./pyramid";

const TILES = CHUNK / TILE;
const ALL_LEVELS = (1 << LEVELS) - 1;

/** The byte for "never observed". */
export const NEVER = 0;

export class Chunk {
  readonly pyramid: Pyramid = emptyPyramid();
  /** For each tile (row by row) a bit for each level that has changed since it was last drawn. */
  readonly stale = new Uint16Array(TILES * TILES).fill(ALL_LEVELS);
  /** Chunk indices: cell (0, 0) of the chunk is (row · 512, col · 512) of the grid. */
  readonly row: number;
  readonly col: number;

  constructor(row: number, col: number) {
    this.row = row;
    this.col = col;
  }
}

/** Called with the grid row and column of each cell that is observed for the first time or crosses log-odds 0. */
export type OnCellChange = (row: number, col: number) => void;

export class Cells {
  readonly #chunks = new Map<number, Chunk>();
  /** Called after each tile that was set. */
  readonly listeners = new Set<(tx: number, ty: number) => void>();
  #revision = 0;

  /** Incremented with every tile that is set. */
  get revision(): number {
    return this.#revision;
  }

  /** The chunk at chunk indices; undefined where nothing was observed. */
  chunk(row: number, col: number): Chunk | undefined {
    return this.#chunks.get(keyOf(row, col));
  }

  chunks(): Iterable<Chunk> {
    return this.#chunks.values();
  }

  /** The byte of a cell; 0 where nothing was observed. */
  at(row: number, col: number): number {
    const chunk = this.#chunks.get(keyOf(row >> 9, col >> 9));
    return chunk?.pyramid[0]?.[((row & (CHUNK - 1)) << 9) | (col & (CHUNK - 1))] ?? NEVER;
  }

  /**
   * Set a tile of int8 values, row 0 at the smallest y. `onChange` is called for cells that are new and
   * for those that crossed `undecided`, the byte of log-odds 0.
   */
  setTile(tx: number, ty: number, values: Uint8Array, undecided = 0, onChange?: OnCellChange): void {
    if (values.length !== TILE * TILE) throw new RangeError(`A tile has ${TILE * TILE} cells, not ${values.length}.`);
    const chunk = this.#chunkOf(ty >> 3, tx >> 3);
    const level0 = chunk.pyramid[0] as Uint8Array;
    const row0 = (ty & (TILES - 1)) * TILE;
    const col0 = (tx & (TILES - 1)) * TILE;
    for (let r = 0, i = 0; r < TILE; r++) {
      let at = (row0 + r) * CHUNK + col0;
      for (let c = 0; c < TILE; c++, i++, at++) {
        const now = (values[i] as number) ^ 0x80; // int8 −128 … 127 → 0 … 255
        const old = level0[at] as number;
        if (now === old) continue;
        level0[at] = now;
        if (onChange && (old === NEVER || now > undecided !== old > undecided)) onChange(ty * TILE + r, tx * TILE + c);
      }
    }
    this.#note(chunk, tx, ty);
  }

  /** Set single cells of a tile: `places` are row · 64 + column within it, `values` int8. The rest is as in {@link setTile}. */
  setCells(
    tx: number,
    ty: number,
    places: Uint16Array,
    values: Uint8Array,
    undecided = 0,
    onChange?: OnCellChange,
  ): void {
    const chunk = this.#chunkOf(ty >> 3, tx >> 3);
    const level0 = chunk.pyramid[0] as Uint8Array;
    const first = (ty & (TILES - 1)) * TILE * CHUNK + (tx & (TILES - 1)) * TILE;
    for (let i = 0; i < places.length; i++) {
      const place = places[i] as number;
      const row = Math.floor(place / TILE);
      const col = place % TILE;
      const at = first + row * CHUNK + col;
      const now = (values[i] as number) ^ 0x80;
      const old = level0[at] as number;
      level0[at] = now;
      if (onChange && now !== old && (old === NEVER || now > undecided !== old > undecided))
        onChange(ty * TILE + row, tx * TILE + col);
    }
    this.#note(chunk, tx, ty);
  }

  /** Note that cells of a tile were set. */
  #note(chunk: Chunk, tx: number, ty: number): void {
    this.#revision++;
    reduce(chunk.pyramid, (ty & (TILES - 1)) * TILE, (tx & (TILES - 1)) * TILE, TILE);
    chunk.stale[(ty & (TILES - 1)) * TILES + (tx & (TILES - 1))] = ALL_LEVELS;
    for (const listener of this.listeners) listener(tx, ty);
  }

  /** Copy the bytes of a tile, row by row; false, and nothing copied, where nothing of its chunk was ever observed. */
  readTile(tx: number, ty: number, out: Uint8Array): boolean {
    const level0 = this.chunk(ty >> 3, tx >> 3)?.pyramid[0];
    if (!level0) return false;
    const first = (ty & (TILES - 1)) * TILE * CHUNK + (tx & (TILES - 1)) * TILE;
    for (let r = 0; r < TILE; r++) {
      const at = first + r * CHUNK;
      out.set(level0.subarray(at, at + TILE), r * TILE);
    }
    return true;
  }

  /** Count cells by class: `free` below and `occupied` above two bytes, `undecided` between; cells never observed are not counted. */
  count(below: number, above: number): { free: number; undecided: number; occupied: number } {
    const counts = { free: 0, undecided: 0, occupied: 0 };
    this.histogram().forEach((count, byte) => {
      if (byte === NEVER) return;
      counts[byte < below ? "free" : byte > above ? "occupied" : "undecided"] += count;
    });
    return counts;
  }

  /** The number of cells of each byte (256,). The count of {@link NEVER} is that of the chunks, which may be larger than the map. */
  histogram(): Uint32Array {
    const counts = new Uint32Array(256);
    for (const chunk of this.#chunks.values()) {
      for (const byte of chunk.pyramid[0] as Uint8Array) counts[byte] = (counts[byte] as number) + 1;
    }
    return counts;
  }

  /** The first and last row and column of the observed cells; null while there are none. */
  observedBox(): { row0: number; col0: number; row1: number; col1: number } | null {
    let [row0, col0, row1, col1] = [Infinity, Infinity, -Infinity, -Infinity];
    for (const chunk of this.#chunks.values()) {
      const bytes = chunk.pyramid[0] as Uint8Array;
      for (let row = 0; row < CHUNK; row++) {
        const line = bytes.subarray(row * CHUNK, (row + 1) * CHUNK);
        const first = line.findIndex((byte) => byte !== NEVER);
        if (first < 0) continue;
        row0 = Math.min(row0, chunk.row * CHUNK + row);
        row1 = Math.max(row1, chunk.row * CHUNK + row);
        col0 = Math.min(col0, chunk.col * CHUNK + first);
        col1 = Math.max(col1, chunk.col * CHUNK + line.findLastIndex((byte) => byte !== NEVER));
      }
    }
    return row0 > row1 ? null : { row0, col0, row1, col1 };
  }

  #chunkOf(row: number, col: number): Chunk {
    const key = keyOf(row, col);
    let chunk = this.#chunks.get(key);
    if (!chunk) {
      chunk = new Chunk(row, col);
      this.#chunks.set(key, chunk);
    }
    return chunk;
  }
}

/** Chunk indices are 16-bit tile indices divided by 8: two of them fit into one key. */
const keyOf = (row: number, col: number): number => (row + 4096) * 8192 + (col + 4096);
