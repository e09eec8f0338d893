import { type ReadonlySignal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useLayoutEffect } from "preact/hooks";

/** The content width of an element in whole pixels, known before its first paint; `first` until it has one. */
export function useWidth(element: RefObject<Element | null>, first: number): ReadonlySignal<number> {
  const width = useSignal(first);
  useLayoutEffect(() => {
    const target = element.current;
    if (!target) return;
    const take = (px: number): void => {
      if (px > 0) width.value = Math.round(px);
    };
    take(target.clientWidth);
    const observer = new ResizeObserver(([entry]) => take(entry?.contentRect.width ?? 0));
    observer.observe(target);
    return () => observer.disconnect();
  }, [element, width]);
  return width;
}
