import { type ReadonlySignal, signal, useComputed } from "@preact/signals";
import type { RefObject } from "preact";
import { useLayoutEffect } from "preact/hooks";
import { useSize } from "./useSize";

/** The size of text for which drawings are laid out, CSS pixels, and the least width that one is laid out for. */
const USUAL_PX = 16;
const LEAST_WIDTH = 300;

/** The size of the page's text, CSS pixels: the reader may change it in the browser's settings at any time. */
const textPx = signal(USUAL_PX);
let probe: HTMLElement | null = null;

function followTextSize(): void {
  if (probe) return;
  probe = document.createElement("div");
  probe.style.cssText = "position: absolute; visibility: hidden; width: 1rem; height: 0";
  document.body.append(probe);
  textPx.value = Number.parseFloat(getComputedStyle(document.documentElement).fontSize) || USUAL_PX;
  new ResizeObserver(([entry]) => {
    if (entry && entry.contentRect.width > 0) textPx.value = entry.contentRect.width;
  }).observe(probe);
}

interface DrawingSize {
  /** The size of the place, in the drawing's own pixels: each is `scale` CSS pixels. */
  readonly width: number;
  readonly height: number;
  readonly scale: number;
}

/**
 * The size of a drawing that is laid out in pixels in an element: where text is larger than usual, the drawing is laid
 * out for a smaller place and enlarged, so that its labels have the room that they usually have; in a narrow place it
 * is enlarged less. It has the class `drawing` and the style `zoom: scale`. `first` is the width until the element has
 * one.
 */
export function useDrawing(element: RefObject<Element | null>, first: number): ReadonlySignal<DrawingSize> {
  const size = useSize(element, first);
  useLayoutEffect(followTextSize, []);
  return useComputed(() => {
    const { width, height } = size.value;
    const scale = Math.min(textPx.value / USUAL_PX, Math.max(1, width / LEAST_WIDTH));
    return { width: Math.floor(width / scale), height: Math.floor(height / scale), scale };
  });
}
