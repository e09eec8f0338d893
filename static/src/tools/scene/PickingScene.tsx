import type { Store } from "../../store/store";
import { written } from "../../ui/numbers";
import { Scene } from "./Scene";
import { type Selection, selectionOf } from "./selection";

interface PickingSceneProps {
  readonly store: Store;
  readonly session: string;
}

/** The 3D view of a log, and a text about the selection in it and on the map. */
export function PickingScene({ store, session }: PickingSceneProps) {
  const selection = selectionOf(store).value;
  return (
    <Scene store={store} session={session}>
      <p class="scene-words" role="status">
        {selection ? wordsOf(selection) : "Click a wall, a pose or a loop to select it, here and on the map."}
      </p>
    </Scene>
  );
}

const DEGREE = 180 / Math.PI;

/** The selection, its values, and where it is explained. */
function wordsOf({ what, place: [x, y], yaw, scans }: Selection): string {
  const place = `x ${written(x, 2)} m, y ${written(y, 2)} m`;
  const names = scans.map((scan) => scan + 1).join(" and ");
  if (what === "scans") return `Scans ${names}, at ${place}: what joins them is under Heal.`;
  if (what === "cell") return `Cell at ${place}: the beams that updated it are under Why.`;
  return `Pose of scan ${names}: ${place}, ${written(yaw * DEGREE, 1)}°. The map is that up to it; edges of a pose graph are under Heal.`;
}
