/** The selection in all views of a page: the explained cell, a pose, or a pair of scans, the latest of them. */

import { effect, type Signal, signal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";

export interface Selection {
  readonly what: "cell" | "pose" | "scans";
  readonly place: Point;
  /** Of the pose, rad; 0 for others. */
  readonly yaw: number;
  /** The corresponding scans, from 0: that of the pose, or both of the pair. */
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

/** Mark the selected place in the page's 3D views, as long as there is one. */
export function useSelectedPlace(store: Store): void {
  useSignalEffect(() => {
    void store.hello.value; // of a new connection, which has no place yet
    store.send({ type: "select", place: selectionOf(store).value?.place ?? null });
  });
  useEffect(() => () => store.send({ type: "select" }), [store]);
}
