/**
 * The figures of the lecture that are not rendered yet. Those near the window are rendered before the next frame is
 * painted, so that no figure in view changes its height; the others one by one when the page is idle.
 */

import { whenIdle } from "../../ui/browser/whenIdle";

/** Time without input before the next task runs. */
const IDLE_MS = 50;

const waiting = new Set<() => void>();
let stop: (() => void) | null = null;

/** Run a task when the browser is idle, or immediately if it has no requestIdleCallback. */
const whenBrowserIdle = (task: () => void): void => {
  if ("requestIdleCallback" in window) requestIdleCallback(task);
  else task();
};

function next(): void {
  stop = whenIdle(IDLE_MS, () =>
    whenBrowserIdle(() => {
      stop = null;
      const [task] = waiting;
      if (!task) return;
      waiting.delete(task);
      task();
      if (waiting.size > 0 && !stop) next();
    }),
  );
}

/**
 * Queue a task until the page has had no input and the browser is idle: one task at a time, in order. The returned
 * function cancels it.
 */
export function enqueueIdleTask(task: () => void): () => void {
  waiting.add(task);
  if (!stop) next();
  return () => {
    waiting.delete(task);
    if (waiting.size > 0) return;
    stop?.();
    stop = null;
  };
}

/** Distance from the window at which a figure is rendered, in window heights. */
const AHEAD = 1;

const awaited = new Map<HTMLElement, () => void>();

/** A hidden figure has a box without size; in the presentation all but one are hidden. */
const isShown = (box: HTMLElement): boolean => box.offsetWidth > 0;

/** Render the figures near the window. */
export function renderNearFigures(): void {
  for (const [box, render] of awaited) {
    const { top, bottom } = box.getBoundingClientRect();
    if (isShown(box) && bottom > -AHEAD * innerHeight && top < (1 + AHEAD) * innerHeight) render();
  }
}

addEventListener("scroll", renderNearFigures, { passive: true });
addEventListener("resize", renderNearFigures, { passive: true });

/** Scroll to a section and render the figures around it: those above it get their height before it is shown. */
export function showSection(id: string): void {
  const section = document.getElementById(id);
  if (!section) return;
  section.scrollIntoView();
  renderNearFigures();
  queueMicrotask(() => section.scrollIntoView()); // components are rendered in a microtask
}

/** Call `render` when a box is near the window or the page is idle. The returned function cancels it. */
export function awaitFigure(box: HTMLElement, render: () => void): () => void {
  awaited.set(box, render);
  const callOff = enqueueIdleTask(() => isShown(box) && render());
  return () => {
    awaited.delete(box);
    callOff();
  };
}
