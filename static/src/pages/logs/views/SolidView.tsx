/** The 3D view of a log: its map and its poses, or its point clouds, which are a session of their own. */

import { useContext } from "preact/hooks";
import type { Store } from "../../../store/store";
import { PickingScene } from "../../../tools/scene/PickingScene";
import { switched } from "../../../ui/bound";
import { SwitchChip } from "../../../ui/dock/SwitchChip";
import { ContentsContext } from "../contents/useContents";
import { Clouds } from "./Clouds";
import { hasClouds, type Solid } from "./solid";

interface SolidViewProps {
  readonly store: Store;
  readonly session: string;
  readonly solid: Solid;
}

export function SolidView({ store, session, solid }: SolidViewProps) {
  const contents = useContext(ContentsContext)?.state.value;
  const log = store.hello.value?.log?.id;
  if (!log || !contents || !(solid.clouds.value || hasClouds(contents))) {
    return <PickingScene store={store} session={session} />;
  }
  return (
    <>
      <div class="actions">
        <SwitchChip
          label="Point clouds"
          title="The point clouds of the log as voxels or points, at the time of the map."
          {...switched(solid.clouds)}
        />
      </div>
      {solid.clouds.value ? (
        <Clouds log={log} main={store} solid={solid} />
      ) : (
        <PickingScene store={store} session={session} />
      )}
    </>
  );
}
