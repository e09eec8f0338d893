/** What the message of a patch means for its figure: its points, the heights to show, and what is just safe. */

import type { Values } from "../../wire/protocol";
import type { Limits, Place } from "./model";

/** x, y, z of one point after the other as points. */
export function placesOf(flat: readonly number[]): readonly Place[] {
  const places: Place[] = [];
  for (let k = 0; k + 2 < flat.length; k += 3)
    places.push([flat[k] as number, flat[k + 1] as number, flat[k + 2] as number]);
  return places;
}

/** The heights that are shown: those of the points, with room to drag them, m. */
export function heightsOf(points: readonly Place[], half: number): readonly [number, number] {
  const all = points.map(([, , z]) => z);
  const low = Math.min(...all);
  const high = Math.max(...all);
  const room = Math.max(0.25 * (high - low), 0.3 * half);
  return [low - 0.3 * room, high + room];
}

/** The limits, weights and rule among the parameters of a terrain. */
export function limitsOf(values: Values): Limits {
  const number = (name: string): number => Number(values[name]);
  return {
    slope: (number("max_slope") * Math.PI) / 180,
    roughness: number("max_roughness"),
    step: number("max_step"),
    weights: [number("slope_weight"), number("roughness_weight"), number("step_weight")],
    isThresholds: values.rule === "thresholds",
  };
}
