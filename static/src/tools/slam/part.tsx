import { lazy } from "../../ui/lazy";
import type { PagePart } from "../part";
import { paintScanPair } from "./scanPair";

const SlamGroup = lazy(async () => (await import("./SlamGroup")).SlamGroup);

export const PART: PagePart = {
  overlay: { watch: (store) => void store.scanPair.value, paint: paintScanPair },
  lab: [
    {
      id: "slam",
      title: "SLAM",
      section: "Errors",
      purpose: "Drifting wheels, and their path corrected while the robot drives",
      keeps: true,
      content: ({ store }) => <SlamGroup store={store} />,
    },
  ],
};
