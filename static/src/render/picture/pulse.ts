import { reducedMotion } from "../../ui/reducedMotion";

const FADE_MS = 260;

/** The strength 0 … 1 of what was cast with the newest scan: full at the scan, then fading. */
export type Pulse = (index: number, now: number) => number;

export function pulse(): Pulse {
  let newest = -1;
  let at = Number.NEGATIVE_INFINITY;
  return (index, now) => {
    if (index !== newest) {
      newest = index;
      at = now;
    }
    if (reducedMotion.peek()) return 0;
    return Math.max(0, 1 - (now - at) / FADE_MS) ** 2;
  };
}
