import { computed, type ReadonlySignal, type Signal, untracked, useSignal, useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import { watchVisibility } from "../../ui/browser/whenIdle";

/**
 * What a figure shows, where that takes long to compute, for example from a map. While the figure is out of sight it
 * keeps what it has, so that a handle that is dragged elsewhere does not wait for figures that are not visible.
 *
 * `current` reads the signals that the value depends on. It must be the same function in each render.
 */
export function useInSight<T>(figure: RefObject<Element | null>, current: () => T): T {
  const isSeen = useSeen(figure);
  const isPrinted = useSignal(false);
  useEffect(() => {
    const print = (): void => {
      isPrinted.value = true;
    };
    const end = (): void => {
      isPrinted.value = false;
    };
    addEventListener("beforeprint", print);
    addEventListener("afterprint", end);
    return () => {
      removeEventListener("beforeprint", print);
      removeEventListener("afterprint", end);
    };
  }, [isPrinted]);
  const value = useMemo(() => {
    let last: { readonly value: T } | null = null;
    return computed(() => {
      // Both are read each time: out of sight the value depends on nothing else.
      const isShown = [isSeen.value, isPrinted.value].includes(true);
      if (isShown) last = { value: current() };
      last ??= { value: untracked(current) };
      return last.value;
    });
  }, [current, isSeen, isPrinted]);
  return value.value;
}

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
