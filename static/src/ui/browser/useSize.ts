import { type ReadonlySignal, useComputed, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useLayoutEffect } from "preact/hooks";

/**
 * CSS pixels of the viewport per CSS pixel of an element: more than 1 where `zoom` enlarges it, as on slides. Pointers
 * and client rectangles are in pixels of the viewport; sizes and coordinates within the element are in its own.
 */
export const zoomOf = (element: Element): number =>
  (element as Element & { readonly currentCSSZoom?: number }).currentCSSZoom ?? 1;

interface Size {
  readonly width: number;
  readonly height: number;
}

/**
 * The content size of an element in whole pixels, known before its first paint; `width` × `height` until it has one.
 * Where a height is given, an element without one keeps the size that it had.
 */
export function useSize(element: RefObject<Element | null>, width: number, height = 0): ReadonlySignal<Size> {
  const size = useSignal<Size>({ width, height });
  useLayoutEffect(() => {
    const target = element.current;
    if (!target) return;
    const take = (wide: number, high: number): void => {
      const now = { width: Math.round(wide), height: Math.round(high) };
      const before = size.peek();
      if (now.width <= 0 || (height > 0 && now.height <= 0)) return;
      if (now.width !== before.width || now.height !== before.height) size.value = now;
    };
    take(target.clientWidth, target.clientHeight);
    const observer = new ResizeObserver(([entry]) => {
      if (entry) take(entry.contentRect.width, entry.contentRect.height);
    });
    observer.observe(target);
    return () => observer.disconnect();
  }, [element, size, height]);
  return size;
}

/** The content width of an element in whole pixels, known before its first paint; `first` until it has one. */
export function useWidth(element: RefObject<Element | null>, first: number): ReadonlySignal<number> {
  const size = useSize(element, first);
  return useComputed(() => size.value.width);
}
