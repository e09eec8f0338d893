import { computed, type ReadonlySignal, useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect, useMemo } from "preact/hooks";
import { reducedMotion } from "../../ui/browser/media";
import { historyOf } from "./history";
import { planOf, type Scene, type Shown, shownOf } from "./scene";

/** Processor time of one animation frame that is spent on scans, ms. */
const SLICE_MS = 7;

/**
 * The map of a scene. When only the number of scans changes, they are added or taken away one after the other; with
 * other conditions the former map stays until the new one is complete. `still` and reduced motion show it at once.
 */
export function useStageMap(scene: ReadonlySignal<Scene>, still: boolean): ReadonlySignal<Shown> {
  const plan = useMemo(() => computed(() => planOf(scene.value)), [scene]);
  const first = useMemo(() => {
    const history = historyOf(plan.peek());
    history.advance(plan.peek(), () => false);
    return { history, count: history.count };
  }, [plan]);
  const now = useSignal(first);
  const wanted = plan.value;
  // Before the paint, so that a picture that is printed or stands still is never that of another scene.
  const step = (isTimeUp: () => boolean, inSteps: boolean): boolean => {
    const history = historyOf(wanted);
    const complete = history.advance(wanted, isTimeUp);
    const { history: before, count } = now.peek();
    const target = wanted.poses.length;
    if (before !== history) {
      if (complete) now.value = { history, count: target };
      return complete;
    }
    const by = inSteps ? Math.sign(target - count) * Math.ceil(Math.abs(target - count) / 16) : target - count;
    const next = Math.min(count + by, history.count);
    if (next !== count || !complete) now.value = { history, count: next };
    return complete && next === target;
  };
  const atOnce = still || reducedMotion.value;
  useLayoutEffect(() => {
    if (atOnce) step(() => false, false);
  }, [wanted, atOnce]);
  useEffect(() => {
    if (atOnce) return;
    let frame = 0;
    let task: ReturnType<typeof setTimeout>;
    const run = (): void => {
      const end = performance.now() + SLICE_MS;
      if (!step(() => performance.now() > end, true)) next();
    };
    // After the paint, so that the handle that changed the scene is painted first.
    const next = (): void => {
      frame = requestAnimationFrame(() => {
        task = setTimeout(run);
      });
    };
    next();
    return () => {
      cancelAnimationFrame(frame);
      clearTimeout(task);
    };
  }, [wanted, atOnce]);
  return useMemo(() => computed(() => shownOf(now.value.history, now.value.count, scene.value)), [now, scene]);
}
