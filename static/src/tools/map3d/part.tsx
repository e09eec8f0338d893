import { lazy } from "../../ui/lazy";
import type { PagePart } from "../part";
import { map3dOver, watchMap3d } from "./over";

const Map3dGroup = lazy(async () => (await import("./Map3dGroup")).Map3dGroup);

export const PART: PagePart = {
  computing: { map_3d: "Computing the 3D map", voxel: "Computing which beams updated the voxel" },
  overlay: { watch: watchMap3d, layers: map3dOver },
  lab: [
    {
      id: "map3d",
      title: "3D map",
      section: "3D",
      purpose: "An octree or a surface, made by a 3D sensor while the robot drives",
      badge: ({ store }) => (store.part("map3d").message.value?.is_on ? "on" : null),
      content: ({ store, session }) => <Map3dGroup store={store} session={session} />,
    },
  ],
};
