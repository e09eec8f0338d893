/** The parts of sessions in the pages. `NAMES` is the only list that names them, each with `part.tsx` in its folder. */

import type { PagePart, PartGroup } from "./part";

/** What they paint over the map is painted in this order. */
// biome-ignore format: a line each, so that a part is one line more
const NAMES = [
  "localization",
  "costmap",
  "path",
  "map3d",
  "placing",
  "slam",
  "why",
  "terrain",
  "measure",
] as const;

const FOUND = import.meta.glob<PagePart>("./*/part.tsx", { eager: true, import: "PART" });

export const PARTS: readonly PagePart[] = NAMES.flatMap((name) => FOUND[`./${name}/part.tsx`] ?? []);

/** The layers and drawings of the parts over the robot's map, from bottom to top. */
export const OVERLAYS = PARTS.flatMap(({ overlay }) => overlay ?? []);

/** The groups of the parts in a section of a page's dock. */
export const groupsOfParts = (page: "lab" | "log" | "volume", section: string): readonly PartGroup[] =>
  PARTS.flatMap((part) => part[page] ?? []).filter((group) => group.section === section);

/** The text shown while the session computes `what`; undefined if no part computes it. */
export const computingText = (what: string): string | undefined =>
  PARTS.map(({ computing }) => computing?.[what]).find((text) => text !== undefined);
