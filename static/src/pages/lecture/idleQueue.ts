import { whenIdle } from "../../ui/whenIdle";

/** How long nobody has been at work on the page when the next task is run. */
const REST_MS = 50;

const waiting = new Set<() => void>();
let stop: (() => void) | null = null;

/** Where a browser cannot say when it is idle, being left alone has to do. */
const whenBrowserIdle = (task: () => void): void => {
  if ("requestIdleCallback" in window) requestIdleCallback(task);
  else task();
};

function next(): void {
  stop = whenIdle(REST_MS, () =>
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
 * Run a task some time, when the browser is idle and nobody is at work on the page: one task at a time, the first that came
 * first. The result calls it off.
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
