import { useSignal, useSignalEffect } from "@preact/signals";
import type { Store } from "../../../store/store";
import { Choice } from "../../../ui/Choice";
import { Panel } from "../../../ui/Panel";
import { sentence, trajectoryLabel } from "../library/describeLog";

/** The choice of the poses for the map. */
export function TrajectoryChoice({ store }: { readonly store: Store }) {
  const picked = useSignal<string | null>(null);
  useSignalEffect(() => {
    // The server has accepted or refused the choice, or somebody else has made another.
    void store.trajectory.value;
    void store.notice.value;
    picked.value = null;
  });
  const log = store.hello.value?.log;
  const trajectories = log?.trajectories ?? [];
  const trajectory = picked.value ?? store.trajectory.value?.name ?? log?.trajectory ?? "";
  const chosen = trajectories.find((known) => known.name === trajectory);
  return (
    <Panel title="Poses of the map">
      {trajectories.length > 1 ? (
        <Choice
          label="Poses from"
          options={trajectories.map((trajectory) => ({
            value: trajectory.name,
            label: trajectoryLabel(trajectory.name),
          }))}
          value={trajectory}
          onChange={(name) => {
            picked.value = name;
            store.send({ type: "trajectory", name });
          }}
        />
      ) : (
        <p>The log has one trajectory: {trajectoryLabel(trajectory)}.</p>
      )}
      {chosen?.description && <p class="quiet">{sentence(chosen.description)}</p>}
    </Panel>
  );
}
