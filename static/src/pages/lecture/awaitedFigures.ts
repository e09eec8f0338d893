/**
 * The figures of the lecture that are not rendered yet. Those near the window are rendered before the window's next
 * frame is painted, so that no figure that is in view changes its height; the others one by one when the page is idle.
 */

import { enqueueIdleTask } from "./idleQueue";

/** Distance from the window at which a figure is rendered, in heights of the window. */
const AHEAD = 1;

const awaited = new Map<HTMLElement, () => void>();

/** Of a hidden figure, as all but one are in the presentation mode, the box has no size. */
const isShown = (box: HTMLElement): boolean => box.offsetWidth > 0;

/** Render the awaited figures near the window. */
export function renderNearFigures(): void {
  for (const [box, render] of awaited) {
    const { top, bottom } = box.getBoundingClientRect();
    if (isShown(box) && bottom > -AHEAD * innerHeight && top < (1 + AHEAD) * innerHeight) render();
  }
}

addEventListener("scroll", renderNearFigures, { passive: true });
addEventListener("resize", renderNearFigures, { passive: true });

/** Scroll to a section, with the figures around it rendered: those above it take their height before it is shown. */
export function showSection(id: string): void {
  const section = document.getElementById(id);
  if (!section) return;
  section.scrollIntoView();
  renderNearFigures();
  queueMicrotask(() => section.scrollIntoView()); // components are rendered in a microtask
}

/** Have `render` called for a box that is near the window, or when the page is idle; the returned function cancels it. */
export function awaitFigure(box: HTMLElement, render: () => void): () => void {
  awaited.set(box, render);
  const callOff = enqueueIdleTask(() => isShown(box) && render());
  return () => {
    awaited.delete(box);
    callOff();
  };
}
