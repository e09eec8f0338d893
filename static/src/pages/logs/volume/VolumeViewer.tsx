import { useSignal, useSignalEffect } from "@preact/signals";
import { ComputingMap } from "../../../tools/picture/ComputingMap";
import { VolumeStage } from "../../../tools/volume/VolumeStage";
import { Button } from "../../../ui/Button";
import { Dock } from "../../../ui/dock/Dock";
import { Icon } from "../../../ui/Icon";
import { SessionEnded } from "../../SessionEnded";
import { useConnected } from "../../useConnected";
import { Transport } from "../Transport";
import { ViewerFrame } from "../ViewerFrame";
import { VolumeFacts } from "./VolumeFacts";
import { volumeGroups } from "./volumeGroups";

interface VolumeViewerProps {
  readonly session: string;
  readonly log: string | null;
  readonly onClose: () => void;
  /** The session has ended on the server: begin another on the same file. */
  readonly onGone: () => void;
  /** Open the session again, compared with another log; null for none. */
  readonly onCompare: (other: string | null) => void;
  /** Open the file again with another axis up; null where it cannot be. */
  readonly onUp: ((axis: string) => void) | null;
}

/** A map in 3D: of point clouds, depth images or an octree. */
export function VolumeViewer({ session, log, onClose, onGone, onCompare, onUp }: VolumeViewerProps) {
  const connection = useConnected(session);
  const { store, status, trouble } = connection;
  const openGroup = useSignal("look");
  const hello = store.hello.value;
  useSignalEffect(() => {
    if (store.part("voxel").message.value?.centre || store.part("surface_voxel").message.value?.centre)
      openGroup.value = "why";
  });
  if (status.value === "gone") {
    return (
      <SessionEnded
        left="The file is still there."
        again="Open it again"
        onAgain={onGone}
        back="All logs"
        onBack={onClose}
      />
    );
  }
  const count = store.frame.value?.count ?? 1;
  return (
    <ViewerFrame
      dock={
        <Dock label="About this map" groups={volumeGroups({ store, session, log, onCompare, onUp })} open={openGroup} />
      }
    >
      <header class="viewer-head">
        <Button kind="quiet" icon="back" label="All logs" onClick={onClose} />
        <h1>{hello?.title ?? "…"}</h1>
      </header>
      <div class="viewer-stage">
        <div class="viewer-map">
          <VolumeStage session={session} store={store} />
          {(!hello || trouble.value) && (
            <p class="viewer-over" role="status">
              {trouble.value ? <Icon name="warning" /> : null} {trouble.value ?? "Opening the map …"}
            </p>
          )}
          <ComputingMap store={store} />
        </div>
        {count > 1 && <Transport store={store} />}
        <div class="viewer-readout">
          <VolumeFacts store={store} />
        </div>
      </div>
    </ViewerFrame>
  );
}
