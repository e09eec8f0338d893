/** The 3D view of a log: its map and its poses, or its point clouds, which are a session of their own. */

import { useSignal } from "@preact/signals";
import { useContext } from "preact/hooks";
import type { Store } from "../../../store/store";
import { PickingScene } from "../../../tools/scene/PickingScene";
import { SwitchChip } from "../../../ui/dock/SwitchChip";
import { ContentsContext } from "../contents/useContents";
import { isCloud } from "../library/describeLog";
import { Clouds } from "./Clouds";

interface SolidViewProps {
  readonly store: Store;
  readonly session: string;
}

export function SolidView({ store, session }: SolidViewProps) {
  const showsClouds = useSignal(false);
  const contents = useContext(ContentsContext)?.state.value;
  const log = store.hello.value?.log?.id;
  const topics = contents?.kind === "ready" ? contents.contents.topics : [];
  if (!log || !topics.some(({ type, messages }) => isCloud(type) && messages > 0)) {
    return <PickingScene store={store} session={session} />;
  }
  return (
    <>
      <div class="actions">
        <SwitchChip
          label="Point clouds"
          title="The point clouds of the log as voxels or points, at the time of the map."
          checked={showsClouds.value}
          onChange={(isOn) => {
            showsClouds.value = isOn;
          }}
        />
      </div>
      {showsClouds.value ? <Clouds log={log} main={store} /> : <PickingScene store={store} session={session} />}
    </>
  );
}
