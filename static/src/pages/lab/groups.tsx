/**
 * The groups of the lab's dock, by what one does there: its first section maps, the others follow the parts of the
 * lecture. A new group is one entry of `GROUPS`; those of the parts are in their folders.
 */

import type { ComponentChildren } from "preact";
import type { Store } from "../../store/store";
import type { Comparison } from "../../tools/compare/comparison";
import { changedOf } from "../../tools/parameters/parameters";
import { groupsOfParts } from "../../tools/parts";
import { ProfileText } from "../../tools/profile/Profile";
import type { ProfileView } from "../../tools/profile/view";
import { Steps } from "../../tools/steps/Steps";
import { WhyGroup } from "../../tools/why/Why";
import type { DockGroup } from "../../ui/dock/Dock";
import { lazy } from "../../ui/lazy";
import { Downloads } from "./groups/Downloads";
import { MapSettings, ModelSettings, SensorSettings } from "./groups/Settings";
import { WorldGroup } from "./groups/World";

const Faults = lazy(async () => (await import("../../tools/faults/Faults")).Faults);
const MovingTable = lazy(async () => (await import("../../tools/table/MovingTable")).MovingTable);
const ClickChoice = lazy(async () => (await import("../../tools/map3d/ClickChoice")).ClickChoice);
const Scene = lazy(async () => (await import("../../tools/scene/Scene")).Scene);

/** What the groups show. */
interface LabView {
  readonly store: Store;
  readonly session: string;
  readonly comparison: Comparison;
  readonly profile: ProfileView;
}

interface Group {
  readonly id: string;
  readonly title: string;
  /** The section that it shares with the groups beside it. */
  readonly section: string;
  /** What the group is for. */
  readonly purpose: string;
  readonly keeps?: boolean;
  readonly isThere?: (view: LabView) => boolean;
  readonly badge?: (view: LabView) => string | null;
  readonly content: (view: LabView) => ComponentChildren;
}

/** The number of parameters of these groups of the table that were changed. */
const changed =
  (...groups: readonly string[]) =>
  ({ store }: LabView): string | null => {
    const rows = store.hello.value?.parameters.table.filter((row) => groups.includes(row.group)) ?? [];
    const count = changedOf(rows, store.mapping.values.value);
    return count > 0 ? String(count) : null;
  };

const GROUPS: readonly Group[] = [
  {
    id: "model",
    title: "Sensor model",
    section: "Mapping",
    purpose: "How a reading becomes evidence",
    badge: changed("model"),
    content: ({ store, profile }) => (
      <>
        <ModelSettings store={store} />
        <ProfileText view={profile} />
      </>
    ),
  },
  {
    id: "map",
    title: "Map",
    section: "Mapping",
    purpose: "How evidence is added up, and the size of the cells",
    badge: changed("update", "map"),
    content: ({ store }) => <MapSettings store={store} />,
  },
  {
    id: "sensor",
    title: "Sensor",
    section: "Mapping",
    purpose: "The robot's sensor, and the mount that the map assumes",
    badge: changed("mount"),
    content: ({ store }) => <SensorSettings store={store} />,
  },
  {
    id: "steps",
    title: "Steps",
    section: "Mapping",
    purpose: "One scan cell by cell, with its numbers",
    content: ({ store }) => <Steps store={store} />,
  },
  {
    id: "why",
    title: "Why",
    section: "Mapping",
    purpose: "Which beams gave a cell its value",
    content: ({ store }) => <WhyGroup store={store} />,
  },
  {
    id: "world",
    title: "Draw",
    section: "World",
    purpose: "Draw walls and furniture; speed and driving",
    content: ({ store }) => <WorldGroup store={store} />,
  },
  {
    id: "share",
    title: "Share",
    section: "World",
    purpose: "Links, and the map as a file",
    content: ({ store, session }) => <Downloads id={session} store={store} />,
  },
  {
    id: "faults",
    title: "Faults",
    section: "Errors",
    purpose: "What goes wrong, and what it looks like in the map",
    badge: ({ store }) => (store.activeFaults.value.on.length > 0 ? String(store.activeFaults.value.on.length) : null),
    content: ({ store, comparison }) => <Faults store={store} comparison={comparison} />,
  },
  {
    id: "table",
    title: "Moving table",
    section: "Errors",
    purpose: "How long a table stays in the map after it is removed",
    keeps: true,
    content: ({ store, comparison }) => <MovingTable store={store} comparison={comparison} />,
  },
  ...groupsOfParts("lab", "Errors"),
  ...groupsOfParts("lab", "Using the map"),
  ...groupsOfParts("lab", "3D"),
  {
    id: "3d",
    title: "3D view",
    section: "3D",
    purpose: "Map, robot and world in three dimensions",
    content: ({ store, session }) => (
      <>
        <Scene session={session} />
        <ClickChoice store={store} />
      </>
    ),
  },
];

/** The groups that this view has, for the dock. */
export function groupsOf(view: LabView): readonly DockGroup[] {
  return GROUPS.filter((group) => group.isThere?.(view) ?? true).map(
    ({ id, title, section, purpose, keeps, badge, content }) => ({
      id,
      title,
      section,
      purpose,
      keeps: keeps ?? false,
      badge: badge?.(view) ?? null,
      content: () => content(view),
    }),
  );
}
