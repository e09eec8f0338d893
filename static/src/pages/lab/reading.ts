import { effect, type ReadonlySignal, signal, untracked } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { tellingReading } from "../../tools/profile/reading";
import { watchVisibility } from "../../ui/visibility";

export type Reading = number | null | undefined;

/** How often the profile follows a beam that somebody points at, and one that nobody points at. */
const POINTED_MS = 100;
const IDLE_MS = 300;
/** With less of the profile in sight nobody watches it, and the page's time belongs to the pictures. */
const LEAST_SHARE = 0.35;

/**
 * The reading of the beam that is looked at, for a profile that redraws itself with each one: that costs more than a
 * frame of both pictures where there is no graphics hardware, so it comes at a calm pace, and while it is seen.
 */
export function useReading(store: Store, place: RefObject<HTMLElement | null>): ReadonlySignal<Reading> {
  const reading = useMemo(() => signal<Reading>(undefined), []);
  useEffect(() => {
    const seen = signal(false);
    const look = ({ intersectionRatio }: IntersectionObserverEntry): void => {
      seen.value = intersectionRatio >= LEAST_SHARE;
    };
    const unwatch = place.current && watchVisibility(place.current, look, { threshold: [0, LEAST_SHARE] });
    let timer: ReturnType<typeof setTimeout> | undefined;
    let readAt = Number.NEGATIVE_INFINITY;
    const read = (): void => {
      timer = undefined;
      readAt = performance.now();
      reading.value = untracked(() => tellingReading(store));
    };
    const stop = effect(() => {
      const beam = store.inspectedBeam.value;
      const pointed = store.probe.value !== null;
      if (!beam || (!pointed && !seen.value && reading.peek() !== undefined)) return;
      timer ??= setTimeout(read, Math.max(0, readAt + (pointed ? POINTED_MS : IDLE_MS) - performance.now()));
    });
    return () => {
      stop();
      unwatch?.();
      clearTimeout(timer);
    };
  }, [store, place, reading]);
  return reading;
}
