import { reducedMotion } from "../../ui/browser/media";

const FADE_MS = 260;

/** The strength 0 … 1 of the beams of the newest scan: 1 at the scan, then fading. */
export type ScanFade = (index: number, now: number) => number;

export function scanFade(): ScanFade {
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
