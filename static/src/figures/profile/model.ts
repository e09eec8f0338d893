/**
 * The inverse sensor model along one beam, as `mapper/sensor_model.py` and the per-beam update compute it.
 *
 * Pure functions of the parameters, checked against vectors that the mapper writes (`vectors.json`). Distances are
 * metres from the sensor, evidence is log-odds. Source: Thrun, Burgard & Fox, Probabilistic Robotics, table 9.2.
 */

/** Which part of the beam a place belongs to. */
export type Zone = "free" | "hit" | "beyond";

/** The parameters that shape the profile; names as in the mapper's parameter table. */
export interface ProfileParameters {
  readonly model: string;
  readonly range_max: number;
  readonly window: number;
  readonly log_odds_hit: number;
  readonly log_odds_miss: number;
  readonly p_free: number;
  readonly p_occ: number;
  readonly log_odds_prior: number;
  readonly no_return: string;
  readonly resolution: number;
}

/** Evidence of a beam in three zones: `inverse_sensor_model − ℓ₀` before the window and in it, 0 beyond. */
export interface BeamModel {
  readonly miss: number;
  readonly hit: number;
  readonly window: number;
}

/** p = 1 − 1 / (1 + exp ℓ). */
export function probability(logOdds: number): number {
  const small = Math.exp(-Math.abs(logOdds));
  return logOdds >= 0 ? 1 / (1 + small) : small / (1 + small);
}

/** ℓ = log(p / (1 − p)). */
export function logOdds(p: number): number {
  return Math.log(p) - Math.log1p(-p);
}

/** The model that the parameters describe. */
export function beamModel(values: ProfileParameters): BeamModel {
  if (values.model === "step_window") {
    const prior = logOdds(probability(values.log_odds_prior));
    return { miss: logOdds(values.p_free) - prior, hit: logOdds(values.p_occ) - prior, window: values.window };
  }
  return { miss: values.log_odds_miss, hit: values.log_odds_hit, window: values.window };
}

/** Whether a reading counts as no return. A reading of NaN or at most 0 is none at all and leaves no evidence. */
export function isNoReturn(z: number, values: ProfileParameters): boolean {
  return z > values.range_max;
}

/** The zone of a place at distance `s` along the beam of a reading `z`. */
export function zoneAt(s: number, z: number, values: ProfileParameters): Zone {
  if (Number.isNaN(z) || z <= 0 || s < 0) return "beyond";
  if (isNoReturn(z, values)) return values.no_return === "free" && s <= values.range_max ? "free" : "beyond";
  const half = values.window / 2;
  if (s < z - half) return "free";
  return Math.abs(s - z) <= half ? "hit" : "beyond";
}

/** The evidence that a zone gets. */
export function evidence(zone: Zone, model: BeamModel): number {
  return zone === "free" ? model.miss : zone === "hit" ? model.hit : 0;
}

/** The profile: what a reading `z` adds, in log-odds, at distance `s`. */
export function increment(s: number, z: number, values: ProfileParameters): number {
  return evidence(zoneAt(s, z, values), beamModel(values));
}

/** Index of the cell that holds distance `s`, for a sensor on the near border of cell 0. */
export function cellAt(s: number, resolution: number): number {
  return Math.floor(s / resolution);
}

/**
 * The zone of cell `index` on a beam along a row of cells. A cell is in the window when its centre is; the cell
 * that holds the endpoint always is; a beam without return frees every cell up to the one that holds the max range.
 */
export function cellZone(index: number, z: number, values: ProfileParameters): Zone {
  const { resolution } = values;
  if (Number.isNaN(z) || z <= 0 || index < 0) return "beyond";
  if (isNoReturn(z, values)) {
    return values.no_return === "free" && index <= cellAt(values.range_max, resolution) ? "free" : "beyond";
  }
  const endpoint = cellAt(z, resolution);
  if (index === endpoint) return "hit";
  if (values.window === 0) return index < endpoint ? "free" : "beyond";
  return zoneAt((index + 0.5) * resolution, z, values);
}

/** The cells [first, last] that count as hit, or null for a beam without return. */
export function hitCells(z: number, values: ProfileParameters): readonly [first: number, last: number] | null {
  if (!(z > 0) || isNoReturn(z, values)) return null;
  const endpoint = cellAt(z, values.resolution);
  let first = endpoint;
  let last = endpoint;
  while (first > 0 && cellZone(first - 1, z, values) === "hit") first--;
  while (cellZone(last + 1, z, values) === "hit") last++;
  return [first, last];
}

/** The table's first values: what the figure shows before a session has said its own. */
export const INITIAL: ProfileParameters = {
  model: "fixed_increments",
  range_max: 30,
  window: 0,
  log_odds_hit: 0.85,
  log_odds_miss: -0.4,
  p_free: 0.4,
  p_occ: 0.7,
  log_odds_prior: 0,
  no_return: "ignore",
  resolution: 0.05,
};
