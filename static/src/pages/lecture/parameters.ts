/** The parameters that sections 2 and 4 share: the cell uses the increments of the profile. */

import { computed, signal } from "@preact/signals";
import type { CellParameters } from "../../grid/cellUpdate";
import { INITIAL_CONFIG } from "../../grid/occupancyGrid";
import { beamModel, INITIAL_PARAMETERS } from "../../grid/sensorModel";

const { clamp, log_odds_min, log_odds_max } = INITIAL_CONFIG;

export const parameters = signal<Readonly<Record<string, unknown>>>({
  ...INITIAL_PARAMETERS,
  range_max: 8,
  window: 0.2,
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
