import { type ReadonlySignal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useLayoutEffect } from "preact/hooks";

interface Size {
  readonly width: number;
  readonly height: number;
}

/** The content box of an element in whole pixels, known before its first paint. */
export function useSize(element: RefObject<Element | null>): ReadonlySignal<Size> {
  const size = useSignal<Size>({ width: 640, height: 560 });
  useLayoutEffect(() => {
    const target = element.current;
    if (!target) return;
    const take = (width: number, height: number): void => {
      const next = { width: Math.round(width), height: Math.round(height) };
      const now = size.peek();
      if (width > 0 && height > 0 && (next.width !== now.width || next.height !== now.height)) size.value = next;
    };
    take(target.clientWidth, target.clientHeight);
    const observer = new ResizeObserver(([entry]) => {
      if (entry) take(entry.contentRect.width, entry.contentRect.height);
    });
    observer.observe(target);
    return () => observer.disconnect();
  }, [element, size]);
  return size;
}
