import { lazy } from "../../ui/lazy";
import type { PagePart } from "../part";
import { paintPatch, watchPatch } from "./overlay";

const TerrainGroup = lazy(async () => (await import("./TerrainGroup")).TerrainGroup);
const FileTerrain = lazy(async () => (await import("./FileTerrain")).FileTerrain);

export const PART: PagePart = {
  overlay: { watch: watchPatch, paint: paintPatch },
  lab: [
    {
      id: "terrain",
      title: "Terrain",
      section: "3D",
      purpose: "Planes of the 3D map's points, and where it is safe to drive",
      content: ({ store }) => <TerrainGroup store={store} />,
    },
  ],
  volume: [
    {
      id: "terrain",
      title: "Terrain",
      section: "Ground",
      purpose: "Patches of the points: which are ground, their planes, and where it is safe to drive.",
      content: ({ store }) => <FileTerrain store={store} />,
    },
  ],
};
