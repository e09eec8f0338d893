import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { connect } from "../../../store/connect";
import { ComputingMap } from "../../../tools/picture/ComputingMap";
import { VolumeStage } from "../../../tools/volume/VolumeStage";
import { Button } from "../../../ui/Button";
import { Dock } from "../../../ui/Dock";
import { Icon } from "../../../ui/Icon";
import { toast } from "../../../ui/Toast";
import { exposeHook } from "../../debugHook";
import { Transport } from "../Transport";
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
  const connection = useMemo(() => connect(session), [session]);
  useEffect(() => {
    exposeHook(connection, () => null);
    connection.start();
    return () => connection.stop();
  }, [connection]);
  const { store, status, trouble } = connection;
  const openGroup = useSignal("look");
  const hello = store.hello.value;
  useEffect(() => {
    if (hello) document.title = `${hello.title} · Gridbloom`;
  }, [hello]);
  useSignalEffect(() => {
    const notice = store.notice.value;
    if (notice) toast(notice.message, notice.kind);
  });
  useSignalEffect(() => {
    if (store.voxel.value?.centre || store.surface.voxel.value?.centre) openGroup.value = "why";
  });
  if (status.value === "gone") {
    return (
      <div class="viewer-message" role="alert">
        <h1>This session has ended</h1>
        <p class="prose">The server ends sessions that are idle. The file is still there.</p>
        <div class="actions">
          <Button kind="primary" icon="restart" onClick={onGone}>
            Open it again
          </Button>
          <Button onClick={onClose}>All logs</Button>
        </div>
      </div>
    );
  }
  const count = store.frame.value?.count ?? 1;
  return (
    <div class="viewer">
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
      <Dock label="About this map" groups={volumeGroups({ store, session, log, onCompare, onUp })} open={openGroup} />
    </div>
  );
}
