import { lazy } from "../../ui/lazy";
import type { PagePart } from "../part";
import { costsOver, paintNavigation, watchNavigation } from "./paint";

const CostmapGroup = lazy(async () => (await import("./CostmapGroup")).CostmapGroup);

export const PART: PagePart = {
  computing: { costmap: "Computing the costmap and the path" },
  overlay: { watch: watchNavigation, layers: costsOver, paint: paintNavigation },
  lab: [
    {
      id: "costmap",
      title: "Costmap",
      section: "Using the map",
      purpose: "Layers of costs over the map, as in Nav2",
      content: ({ store }) => <CostmapGroup store={store} />,
    },
  ],
};
