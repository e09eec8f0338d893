/** The cost of a cell by its distance from the nearest obstacle, as `cost_of_distance` in mapper/costmap/costs.py. */

export const LETHAL = 254;
export const INSCRIBED = 253;
export const NO_INFORMATION = 255;

export interface Inflation {
  /** Radius beyond which there is no cost, m. */
  readonly inflation_radius: number;
  /** How fast the cost falls outside the inscribed radius, 1/m. */
  readonly cost_scaling_factor: number;
}

/** The cost at `distance` m from the nearest obstacle, 0 … 254. */
export function costAt(distance: number, inscribedRadius: number, inflation: Inflation): number {
  if (distance === 0) return LETHAL;
  if (distance > inflation.inflation_radius) return 0;
  if (distance <= inscribedRadius) return INSCRIBED;
  return Math.trunc((INSCRIBED - 1) * Math.exp(-inflation.cost_scaling_factor * (distance - inscribedRadius)));
}

/** The scaling factor with which the cost at `distance`, outside the inscribed radius, is `cost`. */
export function factorFor(cost: number, distance: number, inscribedRadius: number): number {
  const share = Math.min(0.999, Math.max(0.001, cost / (INSCRIBED - 1)));
  return -Math.log(share) / Math.max(0.01, distance - inscribedRadius);
}

/** A cost in words. */
export function nameOfCost(cost: number): string {
  if (cost === NO_INFORMATION) return "–";
  if (cost === LETHAL) return "lethal";
  if (cost === INSCRIBED) return "inscribed";
  return cost === 0 ? "free" : String(cost);
}
