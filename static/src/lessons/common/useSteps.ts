import { type ReadonlySignal, type Signal, useSignal, useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect } from "preact/hooks";
import { watchVisibility } from "../../ui/browser/visibility";

/** Whether an element is on screen in a visible tab. */
export function useSeen(element: RefObject<Element | null>): ReadonlySignal<boolean> {
  const seen = useSignal(false);
  useEffect(() => {
    const target = element.current;
    if (!target) return;
    let onScreen = false;
    const judge = (): void => {
      seen.value = onScreen && !document.hidden;
    };
    const unwatch = watchVisibility(target, ({ isIntersecting }) => {
      onScreen = isIntersecting;
      judge();
    });
    document.addEventListener("visibilitychange", judge);
    return () => {
      unwatch();
      document.removeEventListener("visibilitychange", judge);
    };
  }, [element, seen]);
  return seen;
}

/** Call `step` every `ms` milliseconds while `playing` and seen; a figure off screen pauses. */
export function useSteps(
  playing: Signal<boolean>,
  seen: ReadonlySignal<boolean>,
  ms: () => number,
  step: () => void,
): void {
  useSignalEffect(() => {
    if (!playing.value || !seen.value) return;
    const timer = setInterval(step, ms());
    return () => clearInterval(timer);
  });
}
