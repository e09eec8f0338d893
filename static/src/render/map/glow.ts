/** Remembers the cells that have just changed, so that the map is seen to fill in. */

/** Cells remembered at once; of more the oldest stop glowing early. */
const CAPACITY = 16384;
/** How long a cell glows. */
export const GLOW_MS = 600;

/** How opaque a cell's glow is so many seconds after it changed. */
export function strengthOf(age: number): number {
  const t = (1000 * age) / GLOW_MS;
  return t < 0 || t > 1 ? 0 : 0.75 * (1 - t) ** 2;
}

export class Glow {
  /** (column, row, seconds) of each cell, a ring. */
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
    const at = 3 * this.#next; // a whole map may change at once: no list is made for each cell
    this.data[at] = col;
    this.data[at + 1] = row;
    this.data[at + 2] = this.seconds(now);
    this.#next = (this.#next + 1) % CAPACITY;
    this.#used = Math.min(CAPACITY, this.#used + 1);
    this.#newest = now;
  }

  /** Whether any cell still glows. */
  isAlive(now: number): boolean {
    return now - this.#newest < GLOW_MS;
  }

  seconds(now: number): number {
    return (now - this.#origin) / 1000;
  }

  clear(): void {
    this.#next = this.#used = 0;
    this.#newest = Number.NEGATIVE_INFINITY;
  }
}
