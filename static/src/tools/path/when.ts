import { effect } from "@preact/signals";

/** Do `task` once `isReady`, which reads signals, is true. */
export function when(isReady: () => boolean, task: () => void): void {
  let isDone = false;
  const stop = effect(() => {
    if (isDone || !isReady()) return;
    isDone = true;
    queueMicrotask(() => {
      stop();
      task();
    });
  });
}
