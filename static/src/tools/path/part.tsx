import { lazy } from "../../ui/lazy";
import type { PagePart, PartGroup } from "../part";

const PathGroup = lazy(async () => (await import("./PathGroup")).PathGroup);

const GROUP = {
  id: "path",
  title: "Path",
  purpose: "A goal, and the cheapest path around the obstacles",
  content: ({ store }) => <PathGroup store={store} />,
} satisfies Omit<PartGroup, "section">;

export const PART: PagePart = {
  lab: [{ ...GROUP, section: "Using the map" }],
  log: [{ ...GROUP, section: "Navigate" }],
};
