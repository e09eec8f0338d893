import { type ReadonlySignal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect } from "preact/hooks";

/** The width of an element in whole pixels; `first` until it was measured. */
export function useWidth(element: RefObject<Element | null>, first: number): ReadonlySignal<number> {
  const width = useSignal(first);
  useEffect(() => {
    const target = element.current;
    if (!target) return;
    const observer = new ResizeObserver(([entry]) => {
      if (entry && entry.contentRect.width > 0) width.value = Math.round(entry.contentRect.width);
    });
    observer.observe(target);
    return () => observer.disconnect();
  }, [element, width]);
  return width;
}
