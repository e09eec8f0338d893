/** The picture of a 3D map, drawn by the server's scene, with the buttons of its camera. */

import { useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { MeasuringButtons, MeasuringIn3d } from "../measure/MapTools";
import { SceneButtons, savePicture } from "../scene/SceneButtons";
import { fullScreen, SceneFrame } from "../scene/SceneFrame";
import { ClipHandles } from "./ClipBox";
import { useLook } from "./useLook";
import "./volume.css";

interface VolumeStageProps {
  readonly session: string;
  readonly store: Store;
}

export function VolumeStage({ session, store }: VolumeStageProps) {
  const group = useRef<HTMLDivElement>(null);
  const look = useLook(store);
  const isThere = store.part("volume").message.value !== null;
  return (
    <div class="volume-stage" ref={group}>
      {isThere && (
        <SceneFrame
          store={store}
          session={session}
          class="volume-scene"
          title="Map in 3D: drag to turn, pinch or scroll to zoom, click a voxel to ask about it"
        />
      )}
      <MeasuringIn3d store={store} snaps={false} />
      <div class="volume-buttons">
        <SceneButtons store={store} session={session}>
          <div class="actions">
            <MeasuringButtons store={store} />
            {look && <ClipHandles look={look} />}
            <Button icon="download" label="Save the picture as PNG" onClick={() => savePicture(group.current)} />
            <Button icon="fit" label="Full screen" onClick={() => fullScreen(group.current)} />
          </div>
        </SceneButtons>
      </div>
    </div>
  );
}
