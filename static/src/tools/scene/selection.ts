/** What is selected in all views of a page: the explained cell, a pose, or a pair of scans; whichever came last. */

import { effect, type Signal, signal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";

export interface Selection {
  readonly what: "cell" | "pose" | "scans";
  readonly place: Point;
  /** Of the pose, rad; 0 for others. */
  readonly yaw: number;
  /** The scans that it is of, from 0: that of the pose, or both of the pair. */
  readonly scans: readonly number[];
}

class SelectionState {
  readonly now: Signal<Selection | null> = signal(null);

  constructor(store: Store) {
    const follow = (what: Selection["what"], found: () => Omit<Selection, "what"> | null): void => {
      effect(() => {
        const next = found();
        if (next) this.now.value = { what, ...next };
        else if (this.now.peek()?.what === what) this.now.value = null;
      });
    };
    follow("scans", () => {
      const pair = store.scanPair.value;
      const [a, b] = pair?.poses ?? [];
      return pair && a && b ? { place: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], yaw: 0, scans: pair.scans } : null;
    });
    follow("cell", () => {
      const place = store.explainedPoint.value;
      return place && { place, yaw: 0, scans: [] };
    });
    follow("pose", () => {
      const picked = store.part("picked").message.value;
      if (picked?.what !== "pose") return null;
      return { place: [picked.x, picked.y], yaw: picked.yaw ?? 0, scans: [(picked.index ?? 1) - 1] };
    });
  }
}

export const selectionOf = (store: Store): Signal<Selection | null> => store.of(SelectionState).now;

/** Have the selected place marked in the 3D views of this page, while one is there. */
export function useSelectedPlace(store: Store): void {
  useSignalEffect(() => {
    void store.hello.value; // of a new connection, which knows of no place
    store.send({ type: "select", place: selectionOf(store).value?.place ?? null });
  });
  useEffect(() => () => store.send({ type: "select" }), [store]);
}
