/** The cells that have just changed: they are highlighted for a moment, so that the growth of the map can be seen. */

/** The largest number of highlighted cells; a further cell replaces the oldest. */
const CAPACITY = 16384;
/** Duration of a highlight. */
const HIGHLIGHT_MS = 600;

/** Opacity of a cell's highlight; `age` is the time since the change in seconds. */
export function opacityOf(age: number): number {
  const t = (1000 * age) / HIGHLIGHT_MS;
  return t < 0 || t > 1 ? 0 : 0.75 * (1 - t) ** 2;
}

export class Highlights {
  /** (column, row, seconds) of each cell, as a ring buffer. */
  readonly data = new Float32Array(3 * CAPACITY);
  readonly #origin: number;
  #next = 0;
  #used = 0;
  #newest = Number.NEGATIVE_INFINITY;

  constructor(now = performance.now()) {
    this.#origin = now;
  }

  get count(): number {
    return this.#used;
  }

  add(row: number, col: number, now: number): void {
    const at = 3 * this.#next; // no allocation per cell: a whole map may change at once
    this.data[at] = col;
    this.data[at + 1] = row;
    this.data[at + 2] = this.seconds(now);
    this.#next = (this.#next + 1) % CAPACITY;
    this.#used = Math.min(CAPACITY, this.#used + 1);
    this.#newest = now;
  }

  /** Whether the highlight of any cell is still visible. */
  isFading(now: number): boolean {
    return now - this.#newest < HIGHLIGHT_MS;
  }

  seconds(now: number): number {
    return (now - this.#origin) / 1000;
  }

  clear(): void {
    this.#next = this.#used = 0;
    this.#newest = Number.NEGATIVE_INFINITY;
  }
}
