import type { Store } from "../../store/store";
import { written } from "../../ui/numbers";
import type { PickedMessage } from "../../wire/protocol";
import { Scene } from "./Scene";

interface PickingSceneProps {
  readonly store: Store;
  readonly session: string;
}

/** The 3D view of a log, and in words what was clicked in it. */
export function PickingScene({ store, session }: PickingSceneProps) {
  const picked = store.part("picked").message.value;
  return (
    <>
      <p class="quiet" role="status">
        {picked ? wordsOf(picked) : "Click a wall, a pose of the path or a loop to select it, here and on the map."}
      </p>
      <Scene session={session} />
    </>
  );
}

const DEGREE = 180 / Math.PI;

/** What was clicked, its values, and where it says why. */
function wordsOf({ what, x, y, yaw, index }: PickedMessage): string {
  const place = `x ${written(x, 2)} m, y ${written(y, 2)} m`;
  if (what === "loop") return `Loop closure at ${place}: its residual and both of its scans are under Heal.`;
  if (what === "cell") return `Cell at ${place}: the beams that updated it are under Why.`;
  return `Pose of scan ${index}: ${place}, ${written((yaw ?? 0) * DEGREE, 1)}°. The map is that of the scans up to it.`;
}
