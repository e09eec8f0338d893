/** The effect of dragging a handle on the parameters: bounds, snapping, coupling. */

import { logOdds, probability } from "../../grid/cellValues";
import { INITIAL_PARAMETERS, type SensorModelParameters } from "../../grid/sensorModel";
import { keyed, type Range, snap } from "../../ui/numbers";
import { SENSOR_MODEL_BOUNDS } from "../../wire/constants";

/** A parameter and its new value. */
export interface Setting {
  readonly name: keyof SensorModelParameters;
  readonly value: number;
}

/** The bounds of a parameter, from the mapper's table. */
export type Bounds = (name: keyof SensorModelParameters) => Range;

const BOUNDS: Partial<Record<keyof SensorModelParameters, Range>> = SENSOR_MODEL_BOUNDS;
const ANY: Range = { low: -100, high: 100, step: 0.01 };

/** Bounds and steps of the mapper's table. */
export const tableBounds: Bounds = (name) => BOUNDS[name] ?? ANY;

/** Bounds of a level of the step window, so that p_free ≤ prior ≤ p_occ. */
function coupled(name: "p_free" | "p_occ", values: SensorModelParameters, bounds: Bounds): Range {
  const prior = probability(values.log_odds_prior);
  const range = bounds(name);
  return name === "p_free"
    ? { ...range, high: Math.min(range.high, prior) }
    : { ...range, low: Math.max(range.low, prior) };
}

/** The parameter of the level "hit" or "miss" in the current model, with its bounds and its value. */
export function level(
  which: "hit" | "miss",
  values: SensorModelParameters,
  bounds: Bounds,
): {
  readonly name: "log_odds_hit" | "log_odds_miss" | "p_free" | "p_occ" | "prior_weight";
  readonly range: Range;
  readonly value: number;
} {
  if (values.model === "hit_counting") {
    return { name: "prior_weight", range: bounds("prior_weight"), value: values.prior_weight };
  }
  if (values.model === "step_window") {
    const name = which === "hit" ? "p_occ" : "p_free";
    return { name, range: coupled(name, values, bounds), value: values[name] };
  }
  const name = which === "hit" ? "log_odds_hit" : "log_odds_miss";
  return { name, range: bounds(name), value: values[name] };
}

function finer(range: Range, fine: boolean): Range {
  return fine ? { ...range, step: range.step / 5 } : range;
}

/** The value of a level's parameter for which the level is at `evidence` log-odds. */
function valueFor(which: "hit" | "miss", evidence: number, values: SensorModelParameters): number {
  const prior = probability(values.log_odds_prior);
  switch (values.model) {
    case "step_window":
      return probability(evidence + logOdds(prior));
    case "hit_counting": {
      // The first visit changes ℓ by ln (1 + 1 / wp); solved for the weight w.
      const share = which === "hit" ? prior : 1 - prior;
      const change = Math.max(1e-3, which === "hit" ? evidence : -evidence);
      return 1 / (share * Math.expm1(change));
    }
    default:
      return evidence;
  }
}

/** Move a level to `evidence` log-odds above the prior. */
export function dragLevel(
  which: "hit" | "miss",
  evidence: number,
  values: SensorModelParameters,
  bounds: Bounds,
  fine = false,
): Setting {
  const { name, range } = level(which, values, bounds);
  const target = valueFor(which, evidence, values);
  return { name, value: snap(target, finer(range, fine)) };
}

/** Move an edge of the window to distance `s` from the sensor. The other edge follows, the reading does not move. */
export function dragEdge(
  side: "near" | "far",
  s: number,
  z: number,
  bounds: Bounds,
  fine = false,
  values: SensorModelParameters = INITIAL_PARAMETERS,
): Setting {
  const half = side === "near" ? z - s : s - z;
  if (values.model === "smooth_ramp") {
    const sigma = half / 2 - values.sigma_growth * z;
    return { name: "sigma", value: snap(sigma, finer(bounds("sigma"), fine)) };
  }
  return { name: "window", value: snap(2 * Math.max(0, half), finer(bounds("window"), fine)) };
}

/** Move the max range to distance `s`. */
export function dragRangeMax(s: number, bounds: Bounds, fine = false): Setting {
  return { name: "range_max", value: snap(s, finer(bounds("range_max"), fine)) };
}

/** The setting after a key press on a level's handle; null for other keys. */
export function keyLevel(
  which: "hit" | "miss",
  key: string,
  shift: boolean,
  values: SensorModelParameters,
  bounds: Bounds,
): Setting | null {
  const { name, range, value } = level(which, values, bounds);
  // The greater the prior weight, the smaller the change by a first hit, so the up key must decrease the weight.
  const along = name === "prior_weight" && which === "hit" ? (OPPOSITE[key] ?? key) : key;
  const next = keyed(along, shift, value, range, range.step / 5);
  return next === null ? null : { name, value: next };
}

const OPPOSITE: Record<string, string> = {
  ArrowUp: "ArrowDown",
  ArrowDown: "ArrowUp",
  ArrowRight: "ArrowLeft",
  ArrowLeft: "ArrowRight",
};

const MIRRORED: Record<string, string> = {
  ArrowLeft: "ArrowRight",
  ArrowRight: "ArrowLeft",
};

/** The setting after a key press on a window edge; the edge moves in the arrow's direction. */
export function keyEdge(
  side: "near" | "far",
  key: string,
  shift: boolean,
  values: SensorModelParameters,
  bounds: Bounds,
): Setting | null {
  const name = values.model === "smooth_ramp" ? "sigma" : "window";
  const range = bounds(name);
  const along = side === "near" ? (MIRRORED[key] ?? key) : key;
  const next = keyed(along, shift, values[name], range, range.step / 5);
  return next === null ? null : { name, value: next };
}

/** The opening angle for which the cone's edge passes through a point `x` ahead and `y` aside, in any unit. */
export function dragOpening(x: number, y: number, bounds: Bounds, fine = false): Setting {
  const range = bounds("opening");
  return { name: "opening", value: snap(2 * Math.atan2(Math.abs(y), Math.max(1e-9, x)), finer(range, fine)) };
}
