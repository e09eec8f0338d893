/**
 * The groups of the lab's dock. The first section is about mapping, the others follow the parts of the lecture. A new
 * group is one entry of `GROUPS`; those of the parts are in their folders.
 */

import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { Store } from "../../store/store";
import type { Comparison } from "../../tools/compare/comparison";
import { Toolbar } from "../../tools/editing/Toolbar";
import { MapFiles } from "../../tools/files/MapFiles";
import { Sensor3d } from "../../tools/map3d/Sensor3d";
import { EditMap } from "../../tools/mapediting/EditMap";
import { ParameterRows } from "../../tools/parameters/ParameterRows";
import { changedOf } from "../../tools/parameters/parameters";
import { groupsOfParts } from "../../tools/parts";
import { PlaceRobot } from "../../tools/placing/Placing";
import { ProfileText } from "../../tools/profile/Profile";
import type { ProfileView } from "../../tools/profile/view";
import { MakePuzzle } from "../../tools/puzzle/MakePuzzle";
import { Steps } from "../../tools/steps/Steps";
import { WhyGroup } from "../../tools/why/Why";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import type { DockGroup } from "../../ui/dock/Dock";
import { lazy } from "../../ui/lazy";
import { LayoutChoice } from "../../ui/stage/LayoutChoice";
import type { Layout } from "../../ui/stage/layout";
import { toast } from "../../ui/Toast";
import { liveAddress, snapshotAddress } from "./session";
import { KINDS, PRESETS } from "./views";

async function copy(text: string, done: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    toast(done);
  } catch {
    toast("The browser does not allow copying. Copy the address of the page instead.");
  }
}

/** Copy a link to a snapshot of the world and the view. */
async function share(id: string, store: Store): Promise<void> {
  try {
    const link = await snapshotAddress(id, store);
    await copy(link, "Link copied. It opens a copy of this world, map and settings.");
  } catch {
    toast("The server does not answer, so no link could be made.", "error");
  }
}

/** Links to this world, and its map as files. */
export function Downloads({ id, store }: { readonly id: string; readonly store: Store }) {
  return (
    <div class="lab-share">
      <div class="actions">
        <Button icon="link" onClick={() => void share(id, store)}>
          Share
        </Button>
        <Button
          icon="link"
          onClick={() =>
            void copy(
              liveAddress(id),
              "Link copied. Everyone who opens it sees this world live and can drive the robot.",
            )
          }
        >
          Live link
        </Button>
      </div>
      <p class="quiet">
        Share makes a link to a copy of this world. Live link makes a link to this world itself: others watch it and
        drive the robot.
      </p>
      <MakePuzzle session={id} />
      <div class="actions">
        <MapFiles session={id} />
        <EditMap session={id} name={store.hello.value?.title ?? "world"} />
      </div>
      <p class="quiet">
        pgm and yaml together are a map for map_server and Nav2; both show the map at the moment of the first download.
        png is an image of the map.
      </p>
    </div>
  );
}

interface SettingsProps {
  readonly store: Store;
}

function Rows({ store, groups }: SettingsProps & { readonly groups: readonly string[] }) {
  const rows = store.hello.value?.parameters.table.filter((row) => groups.includes(row.group)) ?? [];
  return (
    <ParameterRows rows={rows} values={store.mapping.values} set={(name, value) => store.setParameter(name, value)} />
  );
}

function Defaults({ store }: SettingsProps) {
  return (
    <Button kind="quiet" icon="restart" onClick={() => store.reset()}>
      Reset to defaults
    </Button>
  );
}

function ModelSettings({ store }: SettingsProps) {
  return (
    <div class="lab-settings">
      <Rows store={store} groups={["model"]} />
      <Defaults store={store} />
    </div>
  );
}

function MapSettings({ store }: SettingsProps) {
  return (
    <div class="lab-settings">
      <Rows store={store} groups={["update", "map"]} />
      <Defaults store={store} />
    </div>
  );
}

function SensorSettings({ store }: SettingsProps) {
  const table = store.hello.value?.sensor?.table ?? [];
  return (
    <div class="lab-settings lab-sensor">
      <h3>The sensor in the world</h3>
      <ParameterRows rows={table} values={store.sensor.values} set={(name, value) => store.setSensor(name, value)} />
      <Sensor3d store={store} />
      <h3>Its mount, as the map assumes it</h3>
      <Rows store={store} groups={["mount"]} />
      <Defaults store={store} />
    </div>
  );
}

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8].map((speed) => ({ value: String(speed), label: `${speed}×` }));

/** Controls of the world and of the robot's motion. */
function WorldGroup({ store }: { readonly store: Store }) {
  const off = !store.isReady.value;
  const auto = store.auto.value;
  return (
    <div class="lab-world">
      <h3>A click on the world</h3>
      <div class="actions">
        <PlaceRobot store={store} />
        <Toolbar store={store} />
      </div>
      <div class="actions">
        <Button icon="undo" disabled={!store.history.canUndo.value} onClick={() => store.history.undo()}>
          Undo
        </Button>
        <Button icon="redo" disabled={!store.history.canRedo.value} onClick={() => store.history.redo()}>
          Redo
        </Button>
      </div>
      <h3>The robot</h3>
      <div class="actions">
        <Button icon="robot" pressed={auto} disabled={off} onClick={() => store.send({ type: "auto", value: !auto })}>
          Auto-drive
        </Button>
      </div>
      <Choice
        label="Speed"
        options={SPEEDS}
        value={String(store.speed.value)}
        disabled={off}
        onChange={(speed) => store.send({ type: "speed", value: Number(speed) })}
      />
    </div>
  );
}

const Faults = lazy(async () => (await import("../../tools/faults/Faults")).Faults);
const MovingTable = lazy(async () => (await import("../../tools/table/MovingTable")).MovingTable);
const ClickChoice = lazy(async () => (await import("../../tools/map3d/ClickChoice")).ClickChoice);
const Scene = lazy(async () => (await import("../../tools/scene/Scene")).Scene);

/** What the groups display. */
interface LabView {
  /** The layout of the stage; null for a follower of another lab. */
  readonly layout: Signal<Layout> | null;
  readonly store: Store;
  readonly session: string;
  readonly comparison: Comparison;
  readonly profile: ProfileView;
}

interface Group {
  readonly id: string;
  readonly title: string;
  /** The section that it shares with neighbouring groups. */
  readonly section: string;
  /** Its purpose. */
  readonly purpose: string;
  readonly keeps?: boolean;
  readonly isThere?: (view: LabView) => boolean;
  readonly badge?: (view: LabView) => string | null;
  readonly content: (view: LabView) => ComponentChildren;
}

/** The number of changed parameters of these groups of the table. */
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
    purpose: "The robot’s sensor, and the mount that the map assumes",
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
    content: ({ store, session, layout }) => (
      <>
        {layout && <LayoutChoice layout={layout} kinds={KINDS} presets={PRESETS} />}
        {layout?.value.views.includes("3d") ? (
          <p class="hint">The 3D view is on the stage.</p>
        ) : (
          <Scene store={store} session={session} />
        )}
        <ClickChoice store={store} />
      </>
    ),
  },
];

/** The groups of the dock in this view. */
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
