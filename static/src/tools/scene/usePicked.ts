import { untracked, useSignalEffect } from "@preact/signals";
import type { Store } from "../../store/store";

/** Select on the map what was clicked in a 3D view: the cell is explained, a loop is given to `onLoop` by its edge. */
export function usePicked(store: Store, onLoop: (edge: number) => void): void {
  useSignalEffect(() => {
    const picked = store.part("picked").message.value;
    untracked(() => {
      if (!picked) return;
      store.explain(picked.what === "cell" ? [picked.x, picked.y] : null);
      if (picked.edge !== null) onLoop(picked.edge);
    });
  });
}
