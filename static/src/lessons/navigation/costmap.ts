/**
 * Costmaps as Nav2 computes them: the functions of mapper/costmap/textbook.py, and tested with vectors from there.
 * Costs are uint8 by rows, row 0 at the smallest y: 254 lethal, 253 inscribed, 0 free, 255 no information.
 */

import { costAt, INSCRIBED, type Inflation, LETHAL, NO_INFORMATION } from "../../grid/costs";
import type { GridGeometry } from "../../grid/occupancyGrid";

export const FREE = 0;
export type Costs = Uint8Array<ArrayBuffer>;

/** Costs after inflation: cells within the radius of a lethal one get the cost of their distance from the nearest. */
export function inflate(costs: Costs, geometry: GridGeometry, inscribed: number, inflation: Inflation): Costs {
  const { rows, cols, resolution } = geometry;
  const reach = Math.ceil(inflation.inflation_radius / resolution - 1e-9);
  const squared = new Float64Array(costs.length).fill(Number.POSITIVE_INFINITY);
  costs.forEach((cost, i) => {
    if (cost !== LETHAL) return;
    const [row, col] = [Math.floor(i / cols), i % cols];
    for (let r = Math.max(0, row - reach); r <= Math.min(rows - 1, row + reach); r++)
      for (let c = Math.max(0, col - reach); c <= Math.min(cols - 1, col + reach); c++) {
        const d = (r - row) ** 2 + (c - col) ** 2;
        const at = r * cols + c;
        if (d <= reach * reach && d < (squared[at] ?? 0)) squared[at] = d;
      }
  });
  // The radius counts in whole cells, rounded up, as in Nav2.
  const whole = { ...inflation, inflation_radius: reach * resolution + 1e-9 };
  return costs.map((old, i) => {
    const d = squared[i] ?? Number.POSITIVE_INFINITY;
    if (!Number.isFinite(d)) return old;
    const cost = costAt(Math.sqrt(d) * resolution, inscribed, whole);
    if (old === NO_INFORMATION) return cost >= INSCRIBED ? cost : old;
    return Math.max(old, cost);
  });
}

/** Costs after a layer is laid over them with the greater cost: combination_method 1, Nav2's first value. */
export const combine = (master: Costs, layer: Costs): Costs =>
  master.map((old, i) => {
    const cost = layer[i] ?? NO_INFORMATION;
    return cost !== NO_INFORMATION && (old === NO_INFORMATION || old < cost) ? cost : old;
  });
