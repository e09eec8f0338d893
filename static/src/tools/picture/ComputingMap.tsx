import type { Store } from "../../store/store";
import { Working } from "../../ui/Working";

const WHAT: Readonly<Record<string, string>> = {
  costmap: "Computing the costmap and the path",
  localization: "Computing where the robot is",
  map_3d: "Computing the 3D map",
  voxel: "Computing which beams updated the voxel",
  terrain: "Assessing the terrain",
};

/** The progress of what the session computes for long, over the picture of its map, with a button that cancels it. */
export function ComputingMap({ store }: { readonly store: Store }) {
  return (
    <Working
      what={WHAT[store.working.value?.what ?? ""] ?? "Computing the map"}
      work={store.working.value}
      onCancel={() => store.send({ type: "cancel" })}
      isInside
    />
  );
}
