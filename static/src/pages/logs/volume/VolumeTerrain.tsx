import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { BeliefView } from "../../../tools/picture/BeliefView";
import { TerrainGroup } from "../../lab/terrain/TerrainGroup";

/** The terrain of a file's points: the map from above in the colours of its patches, and their parameters. */
export function VolumeTerrain({ store }: { readonly store: Store }) {
  const hasPoints = store.volume.value?.has_scans ?? true;
  useEffect(
    () => () => {
      store.pinned.value = null;
    },
    [store],
  );
  if (!hasPoints) return <p class="quiet">An octree has no points: a terrain is made of a cloud.</p>;
  return (
    <div class="volume-above">
      <div class="volume-above-map">
        <BeliefView store={store} />
      </div>
      <div>
        <TerrainGroup store={store} isFile />
        {store.terrain.message.value?.is_on === true && store.terrain.message.value.truth === null && (
          <p class="quiet">
            Which points are ground is not known. Compare with a file of those that are (tab Compare): κ and the error
            are shown here.
          </p>
        )}
      </div>
    </div>
  );
}
