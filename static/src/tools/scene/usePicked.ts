import { untracked, useSignalEffect } from "@preact/signals";
import type { Store } from "../../store/store";

interface Picks {
  /** Called with the edge of a loop. */
  readonly onLoop: (edge: number) => void;
  /** Called with the scan of a pose, from 0. */
  readonly onPose: (scan: number) => void;
}

/** Select in all views what was clicked in a 3D view; a cell is explained. */
export function usePicked(store: Store, { onLoop, onPose }: Picks): void {
  useSignalEffect(() => {
    const picked = store.part("picked").message.value;
    untracked(() => {
      if (!picked) return;
      store.explain(picked.what === "cell" ? [picked.x, picked.y] : null);
      if (picked.edge !== null) onLoop(picked.edge);
      if (picked.index !== null) onPose(picked.index - 1);
    });
  });
}
