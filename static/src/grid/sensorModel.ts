/**
 * The inverse sensor model along one beam, as `mapper/mapping/sensor_model.py` and the per-beam update compute it.
 *
 * Pure functions of the parameters, checked against vectors that the mapper writes (sensorModel.vectors.json).
 * Distances are metres from the sensor, evidence is log-odds. Source: Thrun, Burgard & Fox, Probabilistic Robotics,
 * table 9.2; of the other models the sources that the mapper names.
 */

import { SENSOR_MODEL_INITIAL } from "../wire/constants";
import { logOdds, probability } from "./cellValues";

export type CellEvent = "hit" | "miss";

export interface CellParameters extends SensorModelParameters {
  readonly clamp: boolean;
  readonly log_odds_min: number;
  readonly log_odds_max: number;
}

/**
 * The log-odds of a cell before the first reading and after each of `events`: `ℓ ← clamp(ℓ + evidence)`, as in
 * `mapper/mapping/integrate.py`.
 */
export function logOddsHistory(events: readonly CellEvent[], values: CellParameters): readonly number[] {
  const model = beamModel(values);
  const low = values.clamp ? values.log_odds_min : Number.NEGATIVE_INFINITY;
  const high = values.clamp ? values.log_odds_max : Number.POSITIVE_INFINITY;
  const history = [values.log_odds_prior];
  let now = values.log_odds_prior;
  for (const event of events) {
    now = Math.min(high, Math.max(low, now + model[event]));
    history.push(now);
  }
  return history;
}

/** Number of readings of one kind until the cell crosses a log-odds threshold; null if it never does. */
export function readingsUntil(
  event: CellEvent,
  from: number,
  threshold: number,
  values: CellParameters,
): number | null {
  const step = beamModel(values)[event];
  const over = (value: number): boolean => (event === "hit" ? value > threshold : value < threshold);
  if (over(from)) return 0;
  if (step === 0) return null;
  const limit = event === "hit" ? values.log_odds_max : values.log_odds_min;
  if (values.clamp && !over(limit)) return null;
  return Math.floor((threshold - from) / step + 1e-9) + 1;
}

/** Parts of a beam. */
export type Zone = "free" | "hit" | "beyond";

/** The parameters that shape the profile; names as in the mapper's parameter table. */
export interface SensorModelParameters {
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
  readonly sigma: number;
  readonly sigma_growth: number;
  readonly opening: number;
  readonly cone_profile: string;
  readonly prior_weight: number;
}

/** Evidence of a beam in three zones: `inverse_sensor_model − ℓ₀` before the window and in it, 0 beyond. */
interface BeamModel {
  readonly miss: number;
  readonly hit: number;
}

/** Whether the beam is wide: its evidence depends on distance and angle. */
export const isCone = ({ model }: SensorModelParameters): boolean =>
  model === "sonar_cone" || model === "moravec_elfes";

/** Whether the evidence is constant in each zone; it is not for a ramp and for a Gaussian. */
export const isStepped = (values: SensorModelParameters): boolean =>
  values.model !== "smooth_ramp" &&
  values.model !== "moravec_elfes" &&
  !(values.model === "sonar_cone" && values.cone_profile === "gaussian");

/** The greatest evidence of the model for free and for occupied; for hit counting the change by the first visit. */
export function beamModel(values: SensorModelParameters): BeamModel {
  switch (values.model) {
    case "step_window": {
      const prior = logOdds(probability(values.log_odds_prior));
      return { miss: logOdds(values.p_free) - prior, hit: logOdds(values.p_occ) - prior };
    }
    case "hit_counting": {
      const p = probability(values.log_odds_prior);
      const w = values.prior_weight;
      return { miss: -Math.log1p(1 / (w * (1 - p))), hit: Math.log1p(1 / (w * p)) };
    }
    case "moravec_elfes":
      return { miss: -1, hit: 1 }; // certainties, not log-odds
    default:
      return { miss: values.log_odds_miss, hit: values.log_odds_hit };
  }
}

/**
 * Half the width of the zone around a reading `z` with evidence for occupied, metres; for a cone at least one cell
 * wide.
 */
export function halfWindow(z: number, values: SensorModelParameters): number {
  if (isCone(values)) return Math.max(values.window, values.resolution) / 2;
  return values.model === "smooth_ramp" ? 2 * (values.sigma + values.sigma_growth * z) : values.window / 2;
}

/** Whether a reading counts as no return. A reading that is NaN or at most 0 is invalid and gives no evidence. */
export function isNoReturn(z: number, values: SensorModelParameters): boolean {
  return z > values.range_max && values.no_return !== "hit";
}

/**
 * The reading that the map uses: with the setting no return as a hit, a reading that is too far becomes the max range.
 */
export function effectiveReading(z: number, values: SensorModelParameters): number {
  return values.no_return === "hit" ? Math.min(z, values.range_max) : z;
}

/** The zone of a point at distance `r` along the beam of a reading. */
function zoneAt(r: number, reading: number, values: SensorModelParameters): Zone {
  const z = effectiveReading(reading, values);
  if (Number.isNaN(z) || z <= 0 || r < 0) return "beyond";
  if (isNoReturn(z, values)) return values.no_return === "free" && r <= values.range_max ? "free" : "beyond";
  const half = halfWindow(z, values);
  if (r < z - half) return "free";
  return r <= z + half ? "hit" : "beyond";
}

/** The greatest evidence in a zone. */
export function evidence(zone: Zone, model: BeamModel): number {
  return zone === "free" ? model.miss : zone === "hit" ? model.hit : 0;
}

const smoothStep = (t: number): number => {
  const u = Math.min(1, Math.max(0, t));
  return u * u * (3 - 2 * u);
};

/** The smooth ramp in the window of half width `half` around `z`: from the miss to the hit at z, and to 0 behind it. */
export function smoothRamp(r: number, z: number, half: number, { hit, miss }: BeamModel): number {
  const t = (r - z) / half;
  return t <= 0 ? miss + (hit - miss) * smoothStep(t + 1) : hit * smoothStep(1 - t);
}

/** Moravec & Elfes' quadratic in range: 1 at the sensor falling to 0 at the window, and 1 at z in it. */
function rangeWeight(r: number, z: number, half: number): number {
  if (r < z - half) return 1 - (r / (z - half)) ** 2;
  return half > 0 ? 1 - ((r - z) / half) ** 2 : 1;
}

/** The increment of a reading, log-odds, at distance `r` and, in a cone, `theta` radians off its axis. */
export function increment(r: number, reading: number, values: SensorModelParameters, theta = 0): number {
  const z = effectiveReading(reading, values);
  const zone = zoneAt(r, z, values);
  const model = beamModel(values);
  if (isCone(values) && Math.abs(theta) > values.opening / 2) return 0;
  const flat = evidence(zone, model);
  const half = halfWindow(z, values);
  if (isNoReturn(z, values)) {
    if (values.model !== "moravec_elfes") return flat;
    return flat * (1 - (r / values.range_max) ** 2) * (1 - (theta / (values.opening / 2)) ** 2);
  }
  switch (values.model) {
    case "smooth_ramp":
      return zone === "hit" ? smoothRamp(r, z, half, model) : flat;
    case "sonar_cone":
      if (values.cone_profile !== "gaussian" || zone === "beyond") return flat;
      return flat * rangeWeight(r, z, half) * Math.exp(-8 * (theta / values.opening) ** 2);
    case "moravec_elfes": {
      if (zone === "beyond") return 0;
      const off = theta / (values.opening / 2);
      return flat * rangeWeight(r, z, half) * (1 - off * off);
    }
    default:
      return flat;
  }
}

/** Index of the cell that contains distance `r`, for a sensor on the near border of cell 0. */
export function cellIndexAt(r: number, resolution: number): number {
  return Math.floor(r / resolution);
}

/**
 * The zone of cell `index` on a beam along a row of cells. A cell is in the window if its centre is, and the cell with
 * the endpoint of a thin beam always is. For a beam without a return the cells up to the one with the max range are
 * free, for a wide beam those whose centre lies before the max range.
 */
export function cellZone(index: number, reading: number, values: SensorModelParameters): Zone {
  const { resolution } = values;
  const z = effectiveReading(reading, values);
  if (Number.isNaN(z) || z <= 0 || index < 0) return "beyond";
  const centre = (index + 0.5) * resolution;
  if (isCone(values)) {
    if (isNoReturn(z, values)) return values.no_return === "free" && centre < values.range_max ? "free" : "beyond";
    return centre <= values.range_max ? zoneAt(centre, z, values) : "beyond";
  }
  if (isNoReturn(z, values)) {
    return values.no_return === "free" && index <= cellIndexAt(values.range_max, resolution) ? "free" : "beyond";
  }
  const endpoint = cellIndexAt(z, resolution);
  if (index === endpoint) return "hit";
  if (halfWindow(z, values) === 0) return index < endpoint ? "free" : "beyond";
  return zoneAt(centre, z, values);
}

/** The increment of cell `index` on a beam along a row of cells. */
export function cellIncrement(index: number, reading: number, values: SensorModelParameters): number {
  const z = effectiveReading(reading, values);
  const zone = cellZone(index, z, values);
  if (zone === "beyond") return 0;
  const isEndpoint = !isCone(values) && index === cellIndexAt(z, values.resolution) && !isNoReturn(z, values);
  const isFlat = isNoReturn(z, values) && values.model !== "moravec_elfes";
  if (isStepped(values) || isEndpoint || isFlat) return evidence(zone, beamModel(values));
  return increment((index + 0.5) * values.resolution, z, values);
}

/** The cells [first, last] that count as hit, or null for a beam without return. */
export function hitCells(
  reading: number,
  values: SensorModelParameters,
): readonly [first: number, last: number] | null {
  const z = effectiveReading(reading, values);
  if (!(z > 0) || isNoReturn(z, values)) return null;
  const endpoint = cellIndexAt(z, values.resolution);
  if (cellZone(endpoint, z, values) !== "hit") return null;
  let first = endpoint;
  let last = endpoint;
  while (first > 0 && cellZone(first - 1, z, values) === "hit") first--;
  while (cellZone(last + 1, z, values) === "hit") last++;
  return [first, last];
}

/** The table's initial values, which the figure shows until those of a session are known. */
export const INITIAL_PARAMETERS: SensorModelParameters = SENSOR_MODEL_INITIAL;
