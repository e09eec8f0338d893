/** Moments in which nobody is at work on the page. */

const ACTIVITY_EVENTS = ["pointerdown", "pointermove", "wheel", "keydown"] as const;

/**
 * Call `task` once when the page is seen and has been left alone for `ms`; the result calls it off.
 *
 * A pointer that moves without a button pressed is nobody at work.
 */
export function whenIdle(ms: number, task: () => void): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const stop = new AbortController();
  const wait = (): void => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (document.hidden) return; // visibilitychange begins the wait again
      stop.abort();
      task();
    }, ms);
  };
  const disturbed = (event: Event): void => {
    if (event.type === "pointermove" && (event as PointerEvent).buttons === 0) return;
    wait();
  };
  for (const sign of ACTIVITY_EVENTS)
    addEventListener(sign, disturbed, { capture: true, passive: true, signal: stop.signal });
  document.addEventListener("visibilitychange", wait, { signal: stop.signal });
  wait();
  return () => {
    clearTimeout(timer);
    stop.abort();
  };
}
