import { useSignal } from "@preact/signals";
import type { Store } from "../../../store/store";
import { FileButton } from "../../../tools/files/FileButton";
import { mapAddress } from "../../../tools/mapediting/EditMap";
import { mapEditingOf } from "../../../tools/mapediting/state";
import { Button } from "../../../ui/Button";
import { useAttempts } from "../../../ui/browser/attempts";
import { Panel } from "../../../ui/Panel";
import { ask } from "../../../wire/ask";
import type { LogRecord } from "../library/library";

interface SavingProps {
  readonly store: Store;
  readonly session: string;
}

/** Keeps the edited map as a new one of the library, and gives its files. */
export function Saving({ store, session }: SavingProps) {
  const title = store.hello.value?.title ?? "map";
  const typed = useSignal<string | null>(null);
  const { isBusy, failure, attempt } = useAttempts();
  const saved = useSignal<LogRecord | null>(null);
  const name = typed.value ?? `${title}, edited`.slice(0, 100);
  const at = { session_id: session };
  const { edits } = mapEditingOf(store);
  const save = (): Promise<void> =>
    attempt(async () => {
      saved.value = null;
      saved.value = await ask("POST /api/sessions/{session_id}/edited-map", at, { body: { name: name.trim() } });
    });
  const geometry = store.map.value?.geometry;
  const files = [
    ["map.pgm", "pgm"],
    ["map.yaml", "yaml"],
    ...((edits.value?.keepout_cells ?? 0) > 0
      ? ([
          ["keepout.pgm", "Keepout pgm"],
          ["keepout.yaml", "Keepout yaml"],
        ] as const)
      : []),
    ...((edits.value?.speed_cells ?? 0) > 0
      ? ([
          ["speed.pgm", "Speed pgm"],
          ["speed.yaml", "Speed yaml"],
        ] as const)
      : []),
    ...(edits.value?.n ? ([["edits.json", "Edits"]] as const) : []),
  ] as const;
  return (
    <>
      <Panel title="Save as a new map">
        <form
          class="stack-narrow"
          onSubmit={(event) => {
            event.preventDefault();
            void save();
          }}
        >
          <label class="stack-tight">
            <span class="field-label">Name</span>
            <input
              class="field-text"
              type="text"
              maxLength={100}
              required
              value={name}
              onInput={(event) => {
                typed.value = event.currentTarget.value;
              }}
            />
          </label>
          <div class="actions">
            <button class="button primary" type="submit" disabled={isBusy.value || name.trim() === ""}>
              {isBusy.value ? "Saving …" : "Save"}
            </button>
          </div>
        </form>
        {saved.value && (
          <div class="mapediting-saved" role="status">
            <p>
              Saved as <b>{saved.value.name}</b>, among the logs. To find the robot of a log in it, open the log,
              “Localize”, and choose this map.
            </p>
            <div class="actions">
              <Button href={mapAddress(saved.value.id)} icon="map">
                Open it
              </Button>
            </div>
          </div>
        )}
        {failure.value !== null && (
          <p class="failure" role="alert">
            {failure.value}
          </p>
        )}
      </Panel>
      <Panel title="Download">
        <div class="stack-narrow">
          <div class="actions">
            {files.map(([file, label]) => (
              <FileButton key={file} session={session} file={`edited-map/${file}`}>
                {label}
              </FileButton>
            ))}
          </div>
          {geometry && (
            <p class="quiet number">
              {geometry.cols} × {geometry.rows} cells of {Number(geometry.resolution.toFixed(4))} m, origin{" "}
              {geometry.origin.map((value) => value.toFixed(2)).join(", ")}
            </p>
          )}
          <p class="quiet">
            pgm and yaml together are a map for map_server and Nav2; the keepout and speed files are the masks of Nav2’s
            keepout filter and speed filter, the latter in percent (type 1, base 0, multiplier 1). “gridbloom edit”
            applies the file of edits to a map.
          </p>
        </div>
      </Panel>
    </>
  );
}
