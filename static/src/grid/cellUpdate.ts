/** Updates of one cell: `ℓ ← clamp(ℓ + evidence)`, as in `mapper/mapping/integrate.py`. */

import { beamModel, type SensorModelParameters } from "./sensorModel";

export type CellEvent = "hit" | "miss";

export interface CellParameters extends SensorModelParameters {
  readonly clamp: boolean;
  readonly log_odds_min: number;
  readonly log_odds_max: number;
}

/** The log-odds before the first reading and after each of `events`. */
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
