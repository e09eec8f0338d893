import { effect } from "@preact/signals";
import { isPreview, presenting } from "./state";

/**
 * The size for which slides are laid out, CSS pixels. A screen shows them enlarged as a whole, text included. On 1920 ×
 * 1080 the factor is 1.379, so labels of 16 px become 22 px.
 */
export const SLIDE = { width: 1392, height: 783 } as const;

/**
 * Narrower windows are not projectors, of which the smallest have 1024 × 768. Their slides keep the sizes of the page
 * and may scroll.
 */
const SMALLEST = 1000;

const isProjector = (width: number, preview: boolean): boolean => width >= SMALLEST || preview;

/** Whether figures are fitted to the slide: not on a phone, where a slide scrolls and figures are as in the lecture. */
export const fitsFigures = (): boolean => isProjector(innerWidth, isPreview);

export function scaleOf(width: number, height: number, preview: boolean): number {
  if (!isProjector(width, preview)) return 1;
  return Math.min(width / SLIDE.width, height / SLIDE.height);
}

/**
 * The factor by which a slide is reduced when the line of a class takes part of the height, so that what fitted without
 * the line fits above it. `taken` is the height of the line, `left` the remaining height, pixels.
 */
export function shareOf(width: number, left: number, taken: number): number {
  return isProjector(width, false) && left > 0 ? left / (left + taken) : 1;
}

/** Keep the slides enlarged as far as the window allows. The returned function stops it. */
export function keepScale(): () => void {
  const root = document.documentElement;
  const settle = (): void => {
    const on = presenting.value;
    root.classList.toggle("presenting", on);
    root.style.zoom = on ? String(scaleOf(innerWidth, innerHeight, isPreview)) : "";
  };
  const share = (): void => {
    const slide = document.querySelector<HTMLElement>("#main");
    const line = document.querySelector(".class-bar-box");
    if (!slide) return;
    const height = (element: Element | null): number => element?.getBoundingClientRect().height ?? 0;
    const on = presenting.peek() && line !== null;
    slide.style.zoom = on ? String(shareOf(innerWidth, height(slide), height(line))) : "";
  };
  // The line of a class appears and disappears, and grows with a question.
  const sizes = new ResizeObserver(share);
  const app = document.getElementById("app") as HTMLElement;
  const watch = (): void => {
    sizes.disconnect();
    for (const element of app.querySelectorAll(":scope > :is(.presenter, .class-bar-box)")) sizes.observe(element);
    share();
  };
  const children = new MutationObserver(watch);
  children.observe(app, { childList: true });
  const stop = effect(() => {
    settle();
    share();
  });
  addEventListener("resize", settle);
  addEventListener("resize", share);
  watch();
  return () => {
    removeEventListener("resize", settle);
    removeEventListener("resize", share);
    sizes.disconnect();
    children.disconnect();
    stop();
  };
}
