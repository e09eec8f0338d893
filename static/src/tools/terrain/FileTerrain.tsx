import { useEffect } from "preact/hooks";
import type { Store } from "../../store/store";
import { BeliefView } from "../picture/BeliefView";
import { TerrainGroup } from "./TerrainGroup";

/** The terrain of a file's points: the map from above in the colours of its patches, and their parameters. */
export function FileTerrain({ store }: { readonly store: Store }) {
  const hasPoints = store.part("volume").message.value?.has_scans ?? true;
  useEffect(
    () => () => {
      store.pinned.value = null;
    },
    [store],
  );
  if (!hasPoints) return <p class="quiet">An octree has no points: a terrain is made of a cloud.</p>;
  return (
    <div class="volume-above volume-terrain stack">
      <h2 class="visually-hidden">Terrain</h2>
      <div class="volume-above-map">
        <BeliefView store={store} />
      </div>
      <TerrainGroup store={store} isFile />
    </div>
  );
}
