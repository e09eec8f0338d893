/** Which upload is the terrain of a log's costmap: a cloud, or a map that `gridbloom terrain` writes. */

import { useSignal } from "@preact/signals";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { useAttempts } from "../../ui/browser/attempts";
import { ask } from "../../wire/ask";
import type { MapAnswer } from "../../wire/http";
import { type ChosenLog, LogChoice } from "./LogChoice";

const HINT =
  "A cloud in the frame of the log’s poses, z up: its patches are assessed. Or the yaml and pgm of gridbloom terrain: " +
  "free is safe, occupied is unsafe. Both are dropped on the logs page.";

interface TerrainChoiceProps {
  readonly store: Store;
  readonly session: string;
}

export function TerrainChoice({ store, session }: TerrainChoiceProps) {
  const chosen = useSignal<ChosenLog | null>(null);
  const { isBusy, failure, attempt } = useAttempts();
  const terrain = useSignal<MapAnswer | null>(null);
  const choose = (next: ChosenLog | null): Promise<void> =>
    attempt(async () => {
      const body = { log: next?.log ?? null };
      const answer = await ask("PUT /api/sessions/{session_id}/costmap/terrain", { session_id: session }, { body });
      chosen.value = next;
      terrain.value = answer.map;
      store.setPart("costmap", { terrain_layer: next !== null });
    });
  const classes = terrain.value?.classes;
  const patches = classes && `Patches: ${classes.safe} safe, ${classes.unsafe} unsafe, ${classes.unknown} unknown.`;
  return (
    <div class="field">
      <span class="field-label">Terrain</span>
      <LogChoice
        onlyTerrains
        own=""
        chosen={chosen.value}
        disabled={isBusy.value}
        onChoose={(next) => void choose(next)}
      />
      {chosen.value && (
        <Button kind="quiet" disabled={isBusy.value} onClick={() => void choose(null)}>
          Without terrain
        </Button>
      )}
      <p class="navigation-note" role="status">
        {isBusy.value ? "Reading and assessing the terrain …" : (failure.value ?? patches ?? HINT)}
      </p>
    </div>
  );
}
