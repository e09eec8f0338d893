/** The values of the table of how scans are cut, as a person reads and writes them: angles in degrees. */

import type { Parameter } from "../../../wire/protocol";

const DEGREES = 180 / Math.PI;

const factor = (row: Parameter): number => (row.unit === "rad" ? DEGREES : 1);

export const shownUnit = (row: Parameter): string => (row.unit === "rad" ? "°" : row.unit);

/** The bounds in the unit that is shown; rounded inwards, so that what is typed is within the server's. */
export function shownBounds(row: Parameter): readonly [number, number] {
  const inwards = (value: number, up: boolean): number => (up ? Math.ceil : Math.floor)(value * 1e3) / 1e3;
  return [inwards(row.low * factor(row) - 1e-9, true), inwards(row.high * factor(row) + 1e-9, false)];
}

/** By how much the arrow keys change a value, in the unit that is shown. */
export const shownStep = (row: Parameter): number => (row.unit === "pixels" ? 1 : 0.01);

export const shownValue = (row: Parameter, value: number): number => Number((value * factor(row)).toFixed(4));

/** A value as it is shown in the server's unit and within its bounds; NaN for NaN. */
export const statedValue = (row: Parameter, shown: number): number =>
  Math.min(Math.max(shown / factor(row), row.low), row.high);

/** What is wrong with the values together; null where they are a cut. */
export function faultOf(cut: Readonly<Record<string, number>>): string | null {
  const { min_height, max_height, angle_min, angle_max } = cut;
  if (Object.values(cut).some((value) => Number.isNaN(value))) return "Each field needs a number.";
  if (min_height !== undefined && max_height !== undefined && min_height >= max_height)
    return "The lowest height must be below the greatest.";
  if (angle_min !== undefined && angle_max !== undefined && angle_min >= angle_max)
    return "The first bearing must be below the last.";
  return null;
}
