import { type ReadonlySignal, useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect } from "preact/hooks";
import { reducedMotion } from "../../ui/browser/media";
import { between, eased, type View } from "./camera";

const TRAVEL_MS = 900;
/** A frame that took longer counts as this long: on a busy machine the way takes more time, and has no jump. */
const LONGEST_MS = 60;

const isSame = (a: View, b: View): boolean =>
  a.x === b.x && a.y === b.y && a.width === b.width && a.height === b.height && a.strip === b.strip;

/** The view on its way to a target; `still` and reduced motion go there at once. */
export function useCamera(target: View, still: boolean): ReadonlySignal<View> {
  const now = useSignal(target);
  const atOnce = still || reducedMotion.value;
  const { x, y, width, height, strip } = target;
  useLayoutEffect(() => {
    if (atOnce) now.value = target;
  }, [x, y, width, height, strip, atOnce]);
  useEffect(() => {
    const from = now.peek();
    if (atOnce || isSame(from, target)) return;
    let last = performance.now();
    let travelled = 0;
    let frame = 0;
    const run = (): void => {
      const at = performance.now();
      travelled += Math.min(at - last, LONGEST_MS);
      last = at;
      const t = Math.min(1, travelled / TRAVEL_MS);
      now.value = t < 1 ? between(from, target, eased(t)) : target;
      if (t < 1) frame = requestAnimationFrame(run);
    };
    frame = requestAnimationFrame(run);
    return () => cancelAnimationFrame(frame);
  }, [x, y, width, height, strip, atOnce]);
  return now;
}
