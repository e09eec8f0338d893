import type { Store } from "../../../store/store";
import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { bytes } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";

/** The parameters of the map, and what it takes. */
export function VolumeMapGroup({ store }: { readonly store: Store }) {
  const table = store.hello.value?.parameters.table ?? [];
  const notes = store.hello.value?.log?.notes ?? [];
  return (
    <>
      <Panel title="Voxels">
        {table.length === 0 ? (
          <p class="quiet">An octree has no scans: its voxels cannot be made again.</p>
        ) : (
          <ParameterRows
            rows={table}
            values={store.mapping.values}
            set={(name, value) => store.setParameter(name, value)}
          />
        )}
      </Panel>
      <Memory store={store} />
      {notes.length > 0 && (
        <Panel title="Notes on the file">
          <ul class="volume-notes">
            {notes.map((note) => (
              <li key={note}>{note}</li>
            ))}
          </ul>
        </Panel>
      )}
    </>
  );
}

/** The octree beside a dense grid of the same box. */
function Memory({ store }: { readonly store: Store }) {
  const now = store.part("volume").message.value;
  if (!now) return null;
  return (
    <Panel title="Memory">
      <dl class="volume-memory number">
        <dt>Octree</dt>
        <dd>
          {now.nodes === null ? "…" : `${now.nodes.toLocaleString("en")} nodes, ${bytes(5 * now.nodes)} as a file .ot`}
        </dd>
        <dt>Blocks of 8 × 8 × 8</dt>
        <dd>{bytes(now.bytes)}</dd>
        <dt>Dense grid</dt>
        <dd>{bytes(now.dense_bytes)}</dd>
      </dl>
      <p class="quiet">
        A dense grid has four bytes for each voxel of the box around the points. The octree joins eight equal voxels,
        again and again: large free regions are single nodes.
      </p>
    </Panel>
  );
}
