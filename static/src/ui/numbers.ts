/** Arithmetic and formatting of numbers: slider positions, key steps, text. */

export interface Range {
  readonly low: number;
  readonly high: number;
  readonly step: number;
}

/** How many decimals a value of this step has: 0.05 → 2, 1 → 0. */
export function decimals(step: number): number {
  if (!(step > 0)) return 3;
  for (let places = 0; places < 6; places++) {
    const scaled = step * 10 ** places;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-6) return places;
  }
  return 6;
}

/** How many decimals are shown: a step with more than four (a fraction of π) is shown with three. */
export const shownDecimals = (step: number): number => {
  const places = decimals(step);
  return places > 4 ? 3 : places;
};

/**
 * Round a value to its steps (multiples of the step, so that 0 and round values are reachable) and limit it to its
 * range.
 */
export function snap(value: number, range: Range): number {
  const stepped = range.step > 0 ? Math.round(value / range.step) * range.step : value;
  const clean = Number(stepped.toFixed(decimals(range.step)));
  return Math.min(range.high, Math.max(range.low, clean)) + 0;
}

/** Ranges that span a factor of 50 or more have a logarithmic track: 0.5 … 100 m needs room for both ends. */
function isLogarithmic(range: Range): boolean {
  return range.low > 0 && range.high / range.low >= 50;
}

/** Position of a value on its track, 0 … 1. */
export function toFraction(value: number, range: Range): number {
  const inside = Math.min(range.high, Math.max(range.low, value));
  if (range.high <= range.low) return 0;
  if (isLogarithmic(range)) return Math.log(inside / range.low) / Math.log(range.high / range.low);
  return (inside - range.low) / (range.high - range.low);
}

/** The value, rounded to its steps, at a position 0 … 1 on the track. */
export function fromFraction(fraction: number, range: Range): number {
  const f = Math.min(1, Math.max(0, fraction));
  if (isLogarithmic(range)) return snap(range.low * (range.high / range.low) ** f, range);
  return snap(range.low + f * (range.high - range.low), range);
}

/**
 * The value after a key press: arrow keys change it by one step, with Shift by `fine`, Page keys by ten steps, Home and
 * End go to the ends; null for other keys.
 */
export function keyed(key: string, shift: boolean, value: number, range: Range, fine = range.step): number | null {
  const step = shift ? fine : range.step;
  const by = (amount: number): number => snap(value + amount, { ...range, step });
  switch (key) {
    case "ArrowRight":
    case "ArrowUp":
      return by(step);
    case "ArrowLeft":
    case "ArrowDown":
      return by(-step);
    case "PageUp":
      return by(10 * range.step);
    case "PageDown":
      return by(-10 * range.step);
    case "Home":
      return range.low;
    case "End":
      return range.high;
    default:
      return null;
  }
}

/** A number as text: fixed decimals, a true minus sign. */
export function written(value: number, places: number): string {
  return (Object.is(value, -0) ? 0 : value)
    .toFixed(places)
    .replace(/^-(?=0\.?0*$)/, "")
    .replace("-", "−");
}

/** The number that a visitor typed, with a minus sign or a hyphen, a point or a comma; NaN for other text. */
export const numberOf = (text: string): number =>
  text.trim() === "" ? Number.NaN : Number(text.trim().replace("−", "-").replace(",", "."));

/** The same as {@link written} with its sign always shown: +0.85, −0.40. */
export function signed(value: number, places = 2): string {
  const text = written(value, places);
  return value > 0 && Number(value.toFixed(places)) !== 0 ? `+${text}` : text;
}

/** Seconds as minutes and seconds, or hours: 4:05, 1:02:30. */
export function clock(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  const s = String(whole % 60).padStart(2, "0");
  const m = Math.floor(whole / 60) % 60;
  const h = Math.floor(whole / 3600);
  return h > 0 ? `${h}:${String(m).padStart(2, "0")}:${s}` : `${m}:${s}`;
}

/** A number of bytes as text with a unit: 1.5 MB. */
export function bytes(count: number): string {
  if (count < 1000) return `${count} B`;
  const units = ["kB", "MB", "GB"];
  let value = count / 1000;
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1000;
    unit++;
  }
  return `${value < 10 ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}

/** A count with its noun: 1 cell, 2,000 cells. */
export const plural = (count: number, singular: string, many = `${singular}s`): string =>
  `${count.toLocaleString("en")} ${count === 1 ? singular : many}`;
