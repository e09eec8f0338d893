import { useSignal, useSignalEffect } from "@preact/signals";
import type { Store } from "../../../store/store";
import { ComputingMap } from "../../../tools/picture/ComputingMap";
import { lookOf } from "../../../tools/volume/useLook";
import { VolumeStage } from "../../../tools/volume/VolumeStage";
import { Dock } from "../../../ui/dock/Dock";
import { bytes } from "../../../ui/numbers";
import { SessionEnded } from "../../SessionEnded";
import { useConnected } from "../../useConnected";
import { Head } from "../Head";
import { Transport } from "../Transport";
import { ViewerFrame, ViewerStatus } from "../ViewerFrame";
import { type Axis, volumeGroups } from "./volumeGroups";

const many = (n: number): string => n.toLocaleString("en");

/** The size of the map, below its picture. */
function VolumeFacts({ store }: { readonly store: Store }) {
  const now = store.part("volume").message.value;
  if (!now) return <p class="quiet">…</p>;
  const surface = store.part("surface").message.value;
  const isSurface = surface !== null && lookOf(store).values.value.show === "surface";
  const size = now.high.map((high, axis) => high - (now.low[axis] ?? 0));
  return (
    <p class="volume-facts number" data-chunks={now.chunks} data-pending={now.pending} data-occupied={now.occupied}>
      <span>{size.map((side) => side.toFixed(side < 10 ? 1 : 0)).join(" × ")} m</span>
      <span>
        {many(now.points)} {now.has_scans ? "points" : "nodes"}
      </span>
      {isSurface ? (
        <span data-triangles={surface.triangles} data-pending={surface.pending}>
          {many(surface.triangles)} triangles of {surface.index} {surface.index === 1 ? "scan" : "scans"}
        </span>
      ) : (
        <span>
          {many(now.occupied)} voxels occupied{now.free > 0 ? `, ${many(now.free)} free` : ""}
        </span>
      )}
      {isSurface && surface.problem && <span role="status">{surface.problem}</span>}
      {!isSurface && now.pending > 0 && <span role="status">drawing {many(now.pending)} chunks …</span>}
      {now.left_out > 0 && <span>{many(now.left_out)} points left out: beyond the map</span>}
      <span class="visually-hidden">{bytes(now.bytes)} of memory</span>
    </p>
  );
}

interface VolumeViewerProps {
  readonly session: string;
  readonly log: string | null;
  readonly onClose: () => void;
  /** The session has ended on the server: start another one on the same file. */
  readonly onGone: () => void;
  /** Open the session again, compared with another log; null for none. */
  readonly onCompare: (other: string | null) => void;
  /** Open the file again with another axis up; null if that is impossible. */
  readonly onUp: ((axis: Axis) => void) | null;
}

/** A 3D map from point clouds, depth images or an octree. */
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
      <Head store={store} onClose={onClose} />
      <div class="viewer-stage">
        <div class="viewer-map">
          <VolumeStage session={session} store={store} />
          <ViewerStatus hello={hello} trouble={trouble.value} opening="Opening the map …" />
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
