import { whenIdle } from "../../ui/browser/whenIdle";

/** Time without input before the next task is run. */
const IDLE_MS = 50;

const waiting = new Set<() => void>();
let stop: (() => void) | null = null;

/** Run a task when the browser is idle, or at once if it has no requestIdleCallback. */
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
