import { type ReadonlySignal, useComputed } from "@preact/signals";
import type { RefObject } from "preact";
import { useSize } from "./useSize";

/** The content width of an element in whole pixels, known before its first paint; `first` until it has one. */
export function useWidth(element: RefObject<Element | null>, first: number): ReadonlySignal<number> {
  const size = useSize(element, first);
  return useComputed(() => size.value.width);
}
