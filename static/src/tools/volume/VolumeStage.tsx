/** The picture of a map in 3D, drawn by the server's scene, with the buttons of its camera. */

import { useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { fullScreen, SceneFrame } from "../scene/SceneFrame";
import { changeScene } from "../scene/settings";
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
      <div class="volume-buttons">
        <Cameras store={store} session={session} onFullScreen={() => fullScreen(group.current)} />
        {look && <ClipHandles look={look} />}
      </div>
    </div>
  );
}

interface CamerasProps extends VolumeStageProps {
  readonly onFullScreen: () => void;
}

function Cameras({ store, session, onFullScreen }: CamerasProps) {
  const cameras = store.part("scene").message.value?.cameras ?? [];
  return (
    <fieldset class="volume-cameras" aria-label="Camera">
      {cameras.map((camera) => (
        <Button key={camera} onClick={() => void changeScene(session, { camera })}>
          {camera.charAt(0).toUpperCase() + camera.slice(1)}
        </Button>
      ))}
      <Button icon="fit" label="Full screen" onClick={onFullScreen} />
    </fieldset>
  );
}
