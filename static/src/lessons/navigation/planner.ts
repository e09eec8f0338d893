/**
 * Dijkstra's algorithm and A* on a costmap: the functions of mapper/planning/textbook.py, and tested with vectors from
 * there. Cells are indices by rows.
 */

import { INSCRIBED, LETHAL, NO_INFORMATION } from "../../grid/costs";
import type { Costs } from "./costmap";

/** The greatest cost of a straight step. */
const HIGHEST = 253;
const NEIGHBOURS = [
  [0, -1],
  [0, 1],
  [-1, 0],
  [1, 0],
  [-1, -1],
  [-1, 1],
  [1, -1],
  [1, 1],
] as const;

/** What a straight step onto a cell of each value costs, Infinity for blocked; NavFn's numbers. */
export const stepCosts = (allowUnknown: boolean, neutral = 50, factor = 0.8): Float64Array =>
  Float64Array.from({ length: 256 }, (_, cost) => {
    if (cost === LETHAL || cost === INSCRIBED) return Number.POSITIVE_INFINITY;
    if (cost === NO_INFORMATION) return allowUnknown ? HIGHEST : Number.POSITIVE_INFINITY;
    return Math.min(Math.floor(neutral + factor * cost), HIGHEST);
  });

export interface Ground {
  readonly costs: Costs;
  readonly rows: number;
  readonly cols: number;
  readonly table: Float64Array;
}

/** Call `visit` with each cell that a step can lead to, and the length of the step in cells. */
function neighbours(ground: Ground, cell: number, visit: (to: number, length: number) => void): void {
  const { costs, rows, cols, table } = ground;
  const [row, col] = [Math.floor(cell / cols), cell % cols];
  const blocked = (r: number, c: number): boolean => !Number.isFinite(table[costs[r * cols + c] ?? LETHAL]);
  for (const [dr, dc] of NEIGHBOURS) {
    const [r, c] = [row + dr, col + dc];
    if (r < 0 || c < 0 || r >= rows || c >= cols || blocked(r, c)) continue;
    // Not between two blocked cells.
    if (dr !== 0 && dc !== 0 && blocked(row, c) && blocked(r, col)) continue;
    visit(r * cols + c, dr !== 0 && dc !== 0 ? Math.SQRT2 : 1);
  }
}

/** A queue whose least entry comes first; of equal ones the smaller cell. */
class Queue {
  readonly #keys: number[] = [];
  readonly #cells: number[] = [];

  get size(): number {
    return this.#keys.length;
  }

  #before(a: number, b: number): boolean {
    const [x, y] = [this.#keys[a] as number, this.#keys[b] as number];
    return x < y || (x === y && (this.#cells[a] as number) < (this.#cells[b] as number));
  }

  #swap(a: number, b: number): void {
    for (const list of [this.#keys, this.#cells]) {
      const swapped = list[a] as number;
      list[a] = list[b] as number;
      list[b] = swapped;
    }
  }

  push(key: number, cell: number): void {
    this.#keys.push(key);
    this.#cells.push(cell);
    for (let i = this.size - 1; i > 0; ) {
      const up = (i - 1) >> 1;
      if (!this.#before(i, up)) break;
      this.#swap(i, up);
      i = up;
    }
  }

  pop(): readonly [key: number, cell: number] {
    this.#swap(0, this.size - 1);
    const least = [this.#keys.pop() as number, this.#cells.pop() as number] as const;
    for (let i = 0; ; ) {
      let next = i;
      for (const child of [2 * i + 1, 2 * i + 2]) if (child < this.size && this.#before(child, next)) next = child;
      if (next === i) return least;
      this.#swap(i, next);
      i = next;
    }
  }
}

export interface Search {
  /** Cost to come of each cell from the start, Infinity where the search did not find one. */
  readonly potential: Float64Array;
  /** Cells in the order in which they were expanded. */
  readonly order: readonly number[];
}

/** Search from a cell to another; with A* by the estimate of the whole cost, with Dijkstra by the cost to come. */
export function search(ground: Ground, start: number, goal: number, aStar: boolean): Search {
  const { costs, cols, table } = ground;
  const least = aStar ? table.reduce((a, b) => Math.min(a, b)) : 0;
  const estimate = (cell: number): number => {
    const dr = Math.abs(Math.floor(cell / cols) - Math.floor(goal / cols));
    const dc = Math.abs((cell % cols) - (goal % cols));
    return least * (Math.max(dr, dc) + (Math.SQRT2 - 1) * Math.min(dr, dc));
  };
  const potential = new Float64Array(costs.length).fill(Number.POSITIVE_INFINITY);
  const done = new Uint8Array(costs.length);
  const order: number[] = [];
  const queue = new Queue();
  potential[start] = 0;
  queue.push(estimate(start), start);
  while (queue.size > 0) {
    const [, cell] = queue.pop();
    if (done[cell]) continue;
    done[cell] = 1;
    order.push(cell);
    if (cell === goal) break;
    const here = potential[cell] as number;
    neighbours(ground, cell, (to, length) => {
      const cost = here + (table[costs[to] as number] as number) * length;
      if (!done[to] && cost < (potential[to] as number)) {
        potential[to] = cost;
        queue.push(cost + estimate(to), to);
      }
    });
  }
  const most = aStar ? Number.POSITIVE_INFINITY : (potential[goal] as number);
  const reached = potential.map((cost, i) =>
    (aStar ? done[i] === 1 : cost <= most) ? cost : Number.POSITIVE_INFINITY,
  );
  return { potential: reached, order };
}

/** The cells of the cheapest way, from the start to the goal; null where the goal was not reached. */
export function pathBack(
  ground: Ground,
  potential: Float64Array,
  start: number,
  goal: number,
): readonly number[] | null {
  if (!Number.isFinite(potential[goal])) return null;
  const { costs, rows, cols, table } = ground;
  const cells = [goal];
  for (let here = goal; here !== start; ) {
    let [best, before] = [Number.POSITIVE_INFINITY, here];
    const [row, col] = [Math.floor(here / cols), here % cols];
    for (const [dr, dc] of NEIGHBOURS) {
      const [r, c] = [row + dr, col + dc];
      if (r < 0 || c < 0 || r >= rows || c >= cols) continue;
      const from = r * cols + c;
      neighbours(ground, from, (to, length) => {
        if (to !== here) return;
        const cost = (potential[from] as number) + (table[costs[here] as number] as number) * length;
        if (cost < best) [best, before] = [cost, from];
      });
    }
    if (before === here) return null;
    cells.push(before);
    here = before;
  }
  return cells.reverse();
}
