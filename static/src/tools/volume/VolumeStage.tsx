/** The picture of a map in 3D, drawn by the server's scene, with the buttons of its camera. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { isDark, printing } from "../../ui/browser/theme";
import { toast } from "../../ui/Toast";
import type { SceneAnswer } from "../../wire/http";
import { askScene, sceneAddress } from "../scene/settings";
import { useLook } from "./useLook";
import "./volume.css";

interface VolumeStageProps {
  readonly session: string;
  readonly store: Store;
}

export function VolumeStage({ session, store }: VolumeStageProps) {
  const dark = useSignal(isDark.peek());
  const group = useRef<HTMLDivElement>(null);
  useSignalEffect(() => {
    if (!printing.value) dark.value = isDark.value;
  });
  const isThere = store.part("volume").message.value !== null;
  return (
    <div class="volume-stage" ref={group}>
      {isThere && (
        <iframe
          class="volume-scene"
          title="Map in 3D: drag to turn, pinch or scroll to zoom, click a voxel to ask about it"
          src={sceneAddress(session, `plain/${dark.value ? "?darkMode" : ""}`)}
        />
      )}
      <div class="volume-buttons">
        <Cameras session={session} onFullScreen={() => fullScreen(group.current)} />
        <ClipHandles store={store} />
      </div>
    </div>
  );
}

/** Switches the handles of the clip box in the view; its sliders are in the panel. */
function ClipHandles({ store }: { readonly store: Store }) {
  const look = useLook(store);
  if (!look) return null;
  const areShown = look.values.value.cut_handles === true;
  return (
    <Button icon="box" pressed={areShown} onClick={() => look.set("cut_handles", !areShown)}>
      Clip
    </Button>
  );
}

function fullScreen(element: Element | null): void {
  const change = document.fullscreenElement ? document.exitFullscreen() : element?.requestFullscreen?.();
  (change ?? Promise.reject()).catch(() => toast("The browser does not allow the full screen here.", "error"));
}

/** Interval at which the cameras are asked for until the scene is there. */
const AGAIN_MS = 700;

function Cameras({ session, onFullScreen }: { readonly session: string; readonly onFullScreen: () => void }) {
  const now = useSignal<SceneAnswer | null>(null);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const look = async (): Promise<void> => {
      now.value = await askScene(session);
      if (!now.value) timer = setTimeout(() => void look(), AGAIN_MS);
    };
    void look();
    return () => clearTimeout(timer);
  }, [session]);
  const aim = async (camera: string): Promise<void> => {
    if (!(await askScene(session, { camera }))) toast("The server does not answer.", "error");
  };
  return (
    <fieldset class="volume-cameras" aria-label="Camera">
      {(now.value?.cameras ?? []).map((camera) => (
        <Button key={camera} onClick={() => void aim(camera)}>
          {camera.charAt(0).toUpperCase() + camera.slice(1)}
        </Button>
      ))}
      <Button icon="fit" label="Full screen" onClick={onFullScreen} />
    </fieldset>
  );
}
