import { effect } from "@preact/signals";
import { isPreview, presenting } from "./state";

/**
 * The size that slides are laid out for, CSS pixels; a screen shows them enlarged as a whole, type with figures. On
 * 1920 × 1080 it is enlarged by 1.379, so that labels of 16 px are 22 px.
 */
export const SLIDE = { width: 1392, height: 783 } as const;

/** Smaller windows are not projectors: their slides keep the sizes of the page, and may scroll. */
const SMALLEST = 1120;

export function scaleOf(width: number, height: number, preview: boolean): number {
  if (width < SMALLEST && !preview) return 1;
  return Math.min(width / SLIDE.width, height / SLIDE.height);
}

/** Keep the slides enlarged as far as the window allows; the returned function stops it. */
export function keepScale(): () => void {
  const root = document.documentElement;
  const settle = (): void => {
    const on = presenting.value;
    root.classList.toggle("presenting", on);
    root.style.zoom = on ? String(scaleOf(innerWidth, innerHeight, isPreview)) : "";
  };
  const stop = effect(settle);
  addEventListener("resize", settle);
  return () => {
    removeEventListener("resize", settle);
    stop();
  };
}
