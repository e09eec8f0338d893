import { effect, type ReadonlySignal, signal, untracked } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { profileReading } from "../../tools/profile/reading";
import { watchVisibility } from "../../ui/browser/visibility";

export type Reading = number | null | undefined;

/** How often the profile is updated for a beam that is pointed at, and for the default one. */
const POINTED_MS = 100;
const IDLE_MS = 300;
/** If a smaller share of the profile is visible, it is not updated, to leave the time to the pictures. */
const LEAST_SHARE = 0.35;

/**
 * The reading of the inspected beam, for the profile, which is drawn again with each one. Without graphics hardware
 * that takes longer than a frame of both pictures, so it is updated at a low rate and only while visible.
 */
export function useReading(store: Store, place: RefObject<HTMLElement | null>): ReadonlySignal<Reading> {
  const reading = useMemo(() => signal<Reading>(undefined), []);
  useEffect(() => {
    const seen = signal(false);
    const onChange = ({ intersectionRatio }: IntersectionObserverEntry): void => {
      seen.value = intersectionRatio >= LEAST_SHARE;
    };
    const unwatch = place.current && watchVisibility(place.current, onChange, { threshold: [0, LEAST_SHARE] });
    let timer: ReturnType<typeof setTimeout> | undefined;
    let readAt = Number.NEGATIVE_INFINITY;
    const read = (): void => {
      timer = undefined;
      readAt = performance.now();
      reading.value = untracked(() => profileReading(store));
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
