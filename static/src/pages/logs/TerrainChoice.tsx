/** Which map is the terrain of a log's costmap: one of those that `gridbloom terrain` writes, among the uploads. */

import { useSignal } from "@preact/signals";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { type ChosenLog, LogChoice } from "./LogChoice";
import { request } from "./request";

interface TerrainChoiceProps {
  readonly store: Store;
  readonly session: string;
}

export function TerrainChoice({ store, session }: TerrainChoiceProps) {
  const chosen = useSignal<ChosenLog | null>(null);
  const isBusy = useSignal(false);
  const failure = useSignal<string | null>(null);
  const choose = async (next: ChosenLog | null): Promise<void> => {
    isBusy.value = true;
    failure.value = null;
    try {
      await request(`/api/sessions/${encodeURIComponent(session)}/costmap/terrain`, "PUT", { log: next?.log ?? null });
      chosen.value = next;
      store.setNavigation({ terrain_layer: next !== null });
    } catch (error) {
      failure.value = (error as Error).message;
    }
    isBusy.value = false;
  };
  return (
    <div class="field">
      <span class="field-label">Terrain</span>
      <LogChoice onlyMaps own="" chosen={chosen.value} disabled={isBusy.value} onChoose={(next) => void choose(next)} />
      {chosen.value && (
        <Button kind="quiet" disabled={isBusy.value} onClick={() => void choose(null)}>
          Without terrain
        </Button>
      )}
      <p class="navigation-note" role="status">
        {failure.value ??
          "The yaml and pgm of gridbloom terrain, dropped on the logs page: free is safe, occupied is unsafe."}
      </p>
    </div>
  );
}
