import { lazy } from "../../ui/lazy";
import type { PagePart } from "../part";
import { paintLocalization } from "./paint";

const Localization = lazy(async () => (await import("./Localization")).Localization);

export const PART: PagePart = {
  computing: { localization: "Computing where the robot is" },
  overlay: { watch: (store) => void store.part("localization").message.value, paint: paintLocalization },
  lab: [
    {
      id: "localize",
      title: "Localize",
      section: "Using the map",
      purpose: "The robot’s pose by a particle filter; kidnap the robot",
      keeps: true,
      badge: ({ store }) => (store.part("localization").message.value?.is_on ? "on" : null),
      content: ({ store }) => <Localization store={store} />,
    },
  ],
};
