/** The share of a box that the first of its two parts has, as it is dragged and set by keys. */

export interface Limits {
  readonly low: number;
  readonly high: number;
}

const STEP = 0.02;
const FAR = 0.1;

export const limited = (share: number, { low, high }: Limits): number => Math.min(high, Math.max(low, share));

/** The share after a key; null for a key that means nothing here. */
export function keyedShare(key: string, now: number, limits: Limits): number | null {
  const by = (amount: number): number => limited(Math.round((now + amount) * 100) / 100, limits);
  switch (key) {
    case "ArrowRight":
    case "ArrowDown":
      return by(STEP);
    case "ArrowLeft":
    case "ArrowUp":
      return by(-STEP);
    case "PageDown":
      return by(FAR);
    case "PageUp":
      return by(-FAR);
    case "Home":
      return limits.low;
    case "End":
      return limits.high;
    default:
      return null;
  }
}
