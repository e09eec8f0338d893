/** Axes of charts: values to pixels and back, and the positions of ticks. */

/** A linear map from values `low` … `high` to pixels `from` … `to`. */
export interface Scale {
  readonly low: number;
  readonly high: number;
  readonly from: number;
  readonly to: number;
}

export function toPixel(value: number, scale: Scale): number {
  return scale.from + ((value - scale.low) / (scale.high - scale.low)) * (scale.to - scale.from);
}

export function toValue(pixel: number, scale: Scale): number {
  return scale.low + ((pixel - scale.from) / (scale.to - scale.from)) * (scale.high - scale.low);
}

/** The path of a line through points, pixels to a tenth. */
export const linePath = (points: readonly (readonly [x: number, y: number])[]): string =>
  points.map(([x, y], i) => `${i === 0 ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

/** Round values for ticks, about `target` of them: steps of 1, 2 or 5 times a power of ten. */
export function ticks(low: number, high: number, target: number): readonly number[] {
  const rough = (high - low) / Math.max(1, target);
  if (!(rough > 0) || !Number.isFinite(rough)) return [];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((m) => m * power >= rough * 0.999) ?? 10);
  const ticks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++)
    ticks.push(Number((i * step).toFixed(9)));
  return ticks;
}
