/** Calls a task when the page is idle. */

/**
 * Observe the visibility of an element; the returned function stops it. A busy browser reports several changes at once,
 * the oldest first: only the newest is passed on.
 */
export function watchVisibility(
  target: Element,
  onChange: (now: IntersectionObserverEntry) => void,
  options?: IntersectionObserverInit,
): () => void {
  const observer = new IntersectionObserver((entries) => {
    const newest = entries.at(-1);
    if (newest) onChange(newest);
  }, options);
  observer.observe(target);
  return () => observer.disconnect();
}

const ACTIVITY_EVENTS = ["pointerdown", "pointermove", "wheel", "keydown"] as const;

/**
 * Call `task` once when the page is visible and had no input for `ms` milliseconds; the returned function cancels it.
 *
 * Movements of a pointer without a pressed button do not count as input.
 */
export function whenIdle(ms: number, task: () => void): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const stop = new AbortController();
  const wait = (): void => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (document.hidden) return; // visibilitychange restarts the timer
      stop.abort();
      task();
    }, ms);
  };
  const onInput = (event: Event): void => {
    if (event.type === "pointermove" && (event as PointerEvent).buttons === 0) return;
    wait();
  };
  for (const type of ACTIVITY_EVENTS)
    addEventListener(type, onInput, { capture: true, passive: true, signal: stop.signal });
  document.addEventListener("visibilitychange", wait, { signal: stop.signal });
  wait();
  return () => {
    clearTimeout(timer);
    stop.abort();
  };
}
