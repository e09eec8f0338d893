/** Speed limits as the speed filter's mask has them: percent of the greatest speed, or hundredths of a m/s. */

import type { Value } from "../../wire/protocol";

const isAbsolute = (kind: Value | undefined): boolean => kind === "absolute";

/** The unit of the limits and the limit of a value 1 of the mask. */
export const limitUnit = (kind: Value | undefined): { readonly unit: string; readonly step: number } =>
  isAbsolute(kind) ? { unit: "m/s", step: 0.01 } : { unit: "%", step: 1 };

/** The limit of a value of the mask in words. */
export function limitText(value: number, kind: Value | undefined): string {
  const { unit, step } = limitUnit(kind);
  return `${isAbsolute(kind) ? (value * step).toFixed(2) : value} ${unit}`;
}
