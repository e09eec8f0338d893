import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { selected } from "../../../ui/bound";
import { Panel } from "../../../ui/Panel";
import { Select } from "../../../ui/Select";
import { ask } from "../../../wire/ask";
import type { VolumeMessage } from "../../../wire/protocol";
import type { LogRecord } from "../library/library";

interface VolumeCompareProps {
  readonly store: Store;
  readonly log: string | null;
  readonly onCompare: (other: string | null) => void;
}

/** The comparison with an earlier moment of the map, or with another file. */
export function VolumeCompare({ store, log, onCompare }: VolumeCompareProps) {
  const others = useSignal<readonly LogRecord[]>([]);
  const chosen = useSignal("");
  useEffect(() => {
    void ask("GET /api/logs", {}, { query: { limit: 200 } })
      .then((found) => {
        others.value = found.logs.filter((one) => one.clouds > 0 && one.state === "ready" && one.id !== log);
      })
      .catch(() => undefined);
  }, [log]);
  const compared = store.part("volume").message.value?.compared ?? null;
  const frame = store.frame.value;
  return (
    <Panel title="Compare">
      {frame && frame.count > 1 && (
        <>
          <div class="actions">
            <Button onClick={() => store.send({ type: "volume_keep" })}>Keep the map of {frame.index} scans</Button>
          </div>
          <p class="quiet">Then move along the timeline: what differs from the kept map is drawn.</p>
        </>
      )}
      {others.value.length > 0 && (
        <div class="volume-other">
          <label>
            <span>Another file</span>
            <Select
              {...selected(chosen)}
              options={[
                { value: "", label: "choose one" },
                ...others.value.map(({ id, name }) => ({ value: id, label: name })),
              ]}
            />
          </label>
          <Button disabled={chosen.value === ""} onClick={() => onCompare(chosen.value)}>
            Compare
          </Button>
        </div>
      )}
      {compared ? <Changes compared={compared} /> : <p class="quiet">No other map is compared with this one.</p>}
      {compared && (
        <div class="actions">
          <Button onClick={() => store.send({ type: "volume_keep", value: false })}>End the comparison</Button>
        </div>
      )}
    </Panel>
  );
}

function Changes({ compared }: { readonly compared: NonNullable<VolumeMessage["compared"]> }) {
  const rows: readonly (readonly [label: string, count: number, swatch: string])[] = [
    ["appeared: free before, occupied now", compared.appeared, "added"],
    ["vanished: occupied before, free now", compared.vanished, "removed"],
    ["the same in both", compared.same, ""],
    ["known in the other map only", compared.only_first, ""],
    ["known in this map only", compared.only_second, ""],
  ];
  return (
    <>
      <p>Compared with {compared.title}, in voxels:</p>
      <ul class="volume-changes" data-appeared={compared.appeared} data-vanished={compared.vanished}>
        {rows.map(([label, count, swatch]) => (
          <li key={label}>
            <span class={`volume-swatch ${swatch}`} aria-hidden="true" />
            <span class="number">{count.toLocaleString("en")}</span>
            <span>{label}</span>
          </li>
        ))}
      </ul>
    </>
  );
}
