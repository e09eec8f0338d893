/** The axes of the figure of the sensor model: distances, and likelihoods on a logarithmic axis. */

import type { Scale } from "../../render/chart/scale";
import { toPixel, toValue } from "../../render/chart/scale";

/** Decades of likelihood that are shown: below the lowest nothing is told apart. */
export const [LOWEST, HIGHEST] = [-4, 1.3];

export interface LogScale {
  /** The pixel of a likelihood, at the lower end for those that are not shown. */
  readonly at: (likelihood: number) => number;
  /** The likelihood at a pixel, 0 below the axis. */
  readonly of: (pixel: number) => number;
}

export function logScale(from: number, to: number): LogScale {
  const scale: Scale = { low: LOWEST, high: HIGHEST, from, to };
  return {
    at: (likelihood) => toPixel(Math.min(HIGHEST, Math.max(LOWEST, Math.log10(Math.max(likelihood, 1e-12)))), scale),
    of: (pixel) => {
      const power = toValue(pixel, scale);
      return power < LOWEST ? 0 : 10 ** Math.min(power, HIGHEST);
    },
  };
}

/** Distances at which a curve is drawn, closer together around a peak. */
export function distances(reach: number, peak: number, sigma: number): readonly number[] {
  const even = Array.from({ length: 61 }, (_, i) => (reach * i) / 60);
  const near = Array.from({ length: 61 }, (_, i) => peak + sigma * (i / 7.5 - 4));
  return [...even, ...near].filter((z) => z >= 0 && z <= reach).sort((a, b) => a - b);
}
