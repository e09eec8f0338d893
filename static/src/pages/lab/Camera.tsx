/** What the depth camera of the lab's robot sees. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { addressOf } from "../../wire/ask";

interface CameraProps {
  readonly store: Store;
  readonly session: string;
}

export function Camera({ store, session }: CameraProps) {
  const map3d = store.part("map3d");
  const now = map3d.message.value;
  if (!now?.is_on || now.values.sensor !== "depth_camera") {
    return (
      <div class="lab-second">
        <p>What a depth camera on the robot sees. Its images also make the 3D map.</p>
        <Button
          onClick={() => {
            map3d.isEnded.value = false;
            store.setPart("map3d", { sensor: "depth_camera" });
          }}
        >
          Give the robot a depth camera
        </Button>
      </div>
    );
  }
  return (
    <figure class="lab-camera">
      {now.taken > 0 && <DepthImage session={session} taken={now.taken} />}
      <figcaption class="quiet">
        White is 0 m, dark grey {written(Number(now.values.reach), 1)} m; black returned nothing.
      </figcaption>
    </figure>
  );
}

/** The newest image, after so many were taken. The next one is asked for when the last one is there. */
export function DepthImage({ session, taken }: { readonly session: string; readonly taken: number }) {
  const shown = useSignal(taken);
  const isAwaited = useRef(true);
  const next = (isEnded: boolean): void => {
    if (isEnded) isAwaited.current = false;
    if (isAwaited.current || shown.peek() === taken) return;
    isAwaited.current = true;
    shown.value = taken;
  };
  useEffect(() => next(false), [taken]);
  const address = addressOf("GET /api/sessions/{session_id}/depth.png", { session_id: session });
  return (
    <img
      src={`${address}?${shown.value}`}
      alt="Depth image: the nearer the lighter"
      onLoad={() => next(true)}
      onError={() => next(true)}
    />
  );
}
