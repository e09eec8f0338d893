/** The groups of the dock beside a map in 3D. A new group is one entry of `GROUPS`. */

import type { ComponentChildren } from "preact";
import type { Store } from "../../../store/store";
import { groupsOfParts } from "../../../tools/parts";
import { LookGroup } from "../../../tools/volume/LookGroup";
import { VoxelWhy } from "../../../tools/volume/VoxelWhy";
import type { DockGroup } from "../../../ui/dock/Dock";
import { SurfaceGroup } from "./SurfaceGroup";
import { UpChoice } from "./UpChoice";
import { VolumeAbove } from "./VolumeAbove";
import { VolumeCompare } from "./VolumeCompare";
import { VolumeDownloads } from "./VolumeDownloads";
import { VolumeMapGroup } from "./VolumeMapGroup";

/** What the groups show. */
interface VolumeView {
  readonly store: Store;
  readonly session: string;
  /** The id of the log that the map is of; null if it is not known. */
  readonly log: string | null;
  readonly onCompare: (other: string | null) => void;
  /** Open the file again with another axis up; null where it cannot be. */
  readonly onUp: ((axis: string) => void) | null;
}

interface Group {
  readonly id: string;
  readonly title: string;
  /** The section that it shares with the groups beside it. */
  readonly section?: string;
  readonly purpose: string;
  readonly content: (view: VolumeView) => ComponentChildren;
}

const GROUPS: readonly Group[] = [
  {
    id: "look",
    title: "View",
    purpose: "Which part of the map is drawn, and what the colours mean.",
    content: ({ store, onUp }) => (
      <>
        <LookGroup store={store} />
        {onUp && <UpChoice store={store} onUp={onUp} />}
      </>
    ),
  },
  {
    id: "map",
    title: "Map",
    section: "Mapping",
    purpose: "How the points become voxels. After a change the map is made again from all of its points.",
    content: ({ store }) => <VolumeMapGroup store={store} />,
  },
  {
    id: "surface",
    title: "Surface",
    section: "Mapping",
    purpose: "Where the surface is, between voxels: each keeps its mean signed distance to it.",
    content: ({ store }) => <SurfaceGroup store={store} />,
  },
  {
    id: "why",
    title: "Why",
    purpose: "Click a voxel to see which beams gave it its value.",
    content: ({ store }) => <VoxelWhy store={store} />,
  },
  {
    id: "above",
    title: "From above",
    section: "Ground",
    purpose: "The map for a driving robot: a cell is occupied if a voxel of its column is, within a band of heights.",
    content: ({ store, session }) => <VolumeAbove store={store} session={session} />,
  },
  ...groupsOfParts("volume", "Ground"),
  {
    id: "compare",
    title: "Compare",
    purpose: "What appeared and vanished since an earlier moment, or between two files of one place.",
    content: ({ store, log, onCompare }) => <VolumeCompare store={store} log={log} onCompare={onCompare} />,
  },
  {
    id: "download",
    title: "Download",
    purpose: "The map as files.",
    content: ({ store, session }) => <VolumeDownloads store={store} session={session} />,
  },
];

/** The groups for the dock. */
export function volumeGroups(view: VolumeView): readonly DockGroup[] {
  return GROUPS.map(({ content, ...group }) => ({ ...group, content: () => content(view) }));
}
