/** The parameters that the stage and the sections on a cell and on the sensor model share. */

import { computed } from "@preact/signals";
import { INITIAL_CONFIG } from "../../grid/occupancyGrid";
import type { CellParameters } from "../../grid/sensorModel";
import { beamModel, INITIAL_PARAMETERS } from "../../grid/sensorModel";
import { onPath } from "../stage/path";

const { clamp, log_odds_min, log_odds_max } = INITIAL_CONFIG;

export const parameters = onPath<Readonly<Record<string, unknown>>>({
  ...INITIAL_PARAMETERS,
  model: "step_window",
  range_max: 8,
  window: 0.2,
  resolution: 0.1, // as the map on the stage
  clamp,
  log_odds_min,
  log_odds_max,
});

/** The cell of section 2 uses fixed increments, whatever model section 4 shows. */
export const cellParameters = computed(
  () => ({ ...parameters.value, model: "fixed_increments" }) as Readonly<Record<string, unknown>> & CellParameters,
);

export function setParameter(name: string, value: unknown): void {
  parameters.value = { ...parameters.peek(), [name]: value };
}

export const numbersOf = (values: CellParameters): { hit: number; miss: number } => beamModel(values);
