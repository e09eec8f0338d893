import { type ReadonlySignal, type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { whenIdle } from "../../ui/browser/whenIdle";
import { endOf, type Method, STARTS } from "./matching";
import type { Problem } from "./world";

/** Milliseconds without input before a slice of the work is done, and those that it may take. */
const WAIT_MS = 16;
const SLICE_MS = 12;

const COUNT = STARTS.rows * STARTS.cols;
/** Starts are computed in this order, so that the picture is coarse first: 331 and the number of starts are coprime. */
const STRIDE = 331;

export interface Basin {
  /** How the match from each start ends, by cell. */
  readonly ends: Uint8Array;
  readonly done: number;
}

/** The basin of attraction of a method at a heading, computed in slices while the page has no input. */
export function useBasin(
  problem: ReadonlySignal<Problem>,
  method: ReadonlySignal<Method>,
  heading: ReadonlySignal<number>,
  seen: ReadonlySignal<boolean>,
): Signal<Basin> {
  const basin = useSignal<Basin>({ ends: new Uint8Array(COUNT), done: 0 });
  useSignalEffect(() => {
    const now = [problem.value, method.value, heading.value] as const;
    basin.value = { ends: new Uint8Array(COUNT), done: 0 };
    if (!seen.value) return;
    let stop = (): void => undefined;
    const slice = (): void => {
      const { ends, done } = basin.peek();
      const next = ends.slice();
      const until = performance.now() + SLICE_MS;
      let count = done;
      for (; count < COUNT && performance.now() < until; count++) {
        const index = (count * STRIDE) % COUNT;
        next[index] = endOf(...now, index);
      }
      basin.value = { ends: next, done: count };
      if (count < COUNT) stop = whenIdle(WAIT_MS, slice);
    };
    stop = whenIdle(WAIT_MS, slice);
    return () => stop();
  });
  return basin;
}
