import { type Brush, paintOutline } from "../../render/picture/brush";
import type { Store } from "../../store/store";
import { lazy } from "../../ui/lazy";
import type { PagePart } from "../part";

const TerrainGroup = lazy(async () => (await import("./TerrainGroup")).TerrainGroup);
const FileTerrain = lazy(async () => (await import("./TerrainGroup")).FileTerrain);

export const PART: PagePart = {
  computing: { terrain: "Assessing the terrain" },
  overlay: { watch: watchPatch, paint: paintPatch },
  lab: [
    {
      id: "terrain",
      title: "Terrain",
      section: "3D",
      purpose: "Planes of the 3D map’s points, and where it is safe to drive",
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

/** Paint the outline of the queried patch over the map. */
function paintPatch(store: Store, brush: Brush): void {
  const patch = store.part("terrain").message.peek()?.patch;
  if (!patch || store.underlay.peek()?.startsWith("terrain") !== true) return;
  const [x, y] = patch.centre;
  const { half } = patch;
  paintOutline(
    brush,
    [
      [x - half, y - half],
      [x + half, y - half],
      [x + half, y + half],
      [x - half, y + half],
    ],
    brush.colours.outline,
  );
}

/** Read every signal that is painted here. */
function watchPatch(store: Store): void {
  void store.part("terrain").message.value;
}
