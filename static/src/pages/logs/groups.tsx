/** The groups of the log page's dock. A new group is one entry of `GROUPS`. */

import { type Signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { SharedView } from "../../render/view";
import type { Store } from "../../store/store";
import type { Comparison } from "../../tools/compare/comparison";
import { FileButton } from "../../tools/files/FileButton";
import { MapFiles } from "../../tools/files/MapFiles";
import { EditMap } from "../../tools/mapediting/EditMap";
import { groupsOfParts } from "../../tools/parts";
import { WhyGroup } from "../../tools/why/Why";
import { Button } from "../../ui/Button";
import { useAttempts } from "../../ui/browser/attempts";
import type { DockGroup } from "../../ui/dock/Dock";
import { Failure } from "../../ui/Failure";
import { saveAs } from "../../ui/files/saveAs";
import { lazy } from "../../ui/lazy";
import { Panel } from "../../ui/Panel";
import { ask, fetched, fileAddress } from "../../wire/ask";
import type { MapAnswer, TrajectoryErrors } from "../../wire/http";
import type { LogInfo } from "../../wire/protocol";
import { Compare } from "./compare/Compare";
import { FrameTree } from "./contents/FrameTree";
import { Pictures } from "./contents/Pictures";
import { Plots } from "./contents/Plots";
import type { Span } from "./contents/series";
import { Topics } from "./contents/Topics";
import { type DoctorState, findingsBadge } from "./Doctor";
import type { FieldsState } from "./fields/useFields";
import { type ChosenLog, LogChoice } from "./LogChoice";
import { Lines } from "./lines/Lines";
import type { LinesState } from "./lines/lines";
import { Localize } from "./localize/Localize";
import type { Localizing } from "./localize/localizing";
import { Messages } from "./messages/Messages";
import { Notes } from "./notes/Notes";
import type { NotesState } from "./notes/useNotes";
import { Overview } from "./overview/Overview";
import type { ScanSeriesState } from "./plots/useScanSeries";
import { Settings } from "./Settings";
import type { SensorState } from "./sensor/useSensor";
import type { Shown } from "./share/links";
import { Share } from "./share/Share";
import { CorrectPoses } from "./slam/CorrectPoses";
import type { PoseCorrection } from "./slam/poseCorrection";
import { Trajectories } from "./trajectories/Trajectories";

const HINT =
  "A cloud in the frame of the log’s poses, z up: its patches are assessed. Or the yaml and pgm of gridbloom terrain: " +
  "free is safe, occupied is unsafe. Both are dropped on the logs page.";

interface TerrainChoiceProps {
  readonly store: Store;
  readonly session: string;
}

function TerrainChoice({ store, session }: TerrainChoiceProps) {
  const chosen = useSignal<ChosenLog | null>(null);
  const { isBusy, failure, attempt } = useAttempts();
  const terrain = useSignal<MapAnswer | null>(null);
  const choose = (next: ChosenLog | null): Promise<void> =>
    attempt(async () => {
      const body = { log: next?.log ?? null };
      const answer = await ask("PUT /api/sessions/{session_id}/costmap/terrain", { session_id: session }, { body });
      chosen.value = next;
      terrain.value = answer.map;
      store.setPart("costmap", { terrain_layer: next !== null });
    });
  const classes = terrain.value?.classes;
  const patches = classes && `Patches: ${classes.safe} safe, ${classes.unsafe} unsafe, ${classes.unknown} unknown.`;
  return (
    <div class="field">
      <span class="field-label">Terrain</span>
      <LogChoice
        onlyTerrains
        own=""
        chosen={chosen.value}
        disabled={isBusy.value}
        onChoose={(next) => void choose(next)}
      />
      {chosen.value && (
        <Button kind="quiet" disabled={isBusy.value} onClick={() => void choose(null)}>
          Without terrain
        </Button>
      )}
      <p class="navigation-note" role="status">
        {isBusy.value ? "Reading and assessing the terrain …" : (failure.value ?? patches ?? HINT)}
      </p>
    </div>
  );
}

/** The report as PDF, which takes the server some seconds to typeset. */
function PdfReport({ session, title }: { readonly session: string; readonly title: string }) {
  const { isBusy, failure, attempt } = useAttempts();
  const make = (): Promise<void> =>
    attempt(async () => {
      const answer = await fetched(fileAddress(session, "report.pdf"));
      saveAs(`${title}.pdf`, await answer.blob());
    });
  return (
    <>
      <Button icon="file" disabled={isBusy.value} onClick={() => void make()}>
        {isBusy.value ? "Making the PDF …" : "Report as PDF"}
      </Button>
      <Failure why={failure.value} />
    </>
  );
}

/** The map as files and, except for a guest, the trajectory. */
export function Downloads({
  session,
  title,
  isGuest,
}: {
  readonly session: string;
  readonly title: string;
  readonly isGuest: boolean;
}) {
  return (
    <Panel title="Download">
      <div class="actions downloads">
        <MapFiles session={session} />
        {!isGuest && (
          <>
            <FileButton session={session} file="run.mcap">
              mcap
            </FileButton>
            <FileButton session={session} file="trajectory.tum">
              Trajectory (TUM)
            </FileButton>
            <Button icon="file" href={fileAddress(session, "report")} target="_blank">
              Report
            </Button>
            <PdfReport session={session} title={title} />
            <EditMap session={session} name={title} />
          </>
        )}
      </div>
      <p class="quiet">
        pgm and yaml together are a map for map_server and Nav2; both show the map at the moment of the first download.
        png is an image of the map.
        {!isGuest &&
          " mcap contains the scans, the poses and this map for Rerun and ROS 2, and for Foxglove and Lichtblick, where the topics /map, /scan and /pose are enabled in the 3D panel."}
      </p>
    </Panel>
  );
}

const PickingScene = lazy(async () => (await import("../../tools/scene/PickingScene")).PickingScene);

/** What the groups display. */
interface LogView {
  readonly store: Store;
  readonly session: string;
  /** For a visitor with a shared link: no other logs and no downloads of this one. */
  readonly isGuest: boolean;
  /** Null until the session has reported it. */
  readonly log: LogInfo | null;
  readonly comparison: Comparison;
  readonly doctor: DoctorState;
  readonly correction: PoseCorrection;
  readonly localizing: Localizing;
  readonly sensor: SensorState;
  /** The id of the open group. */
  readonly openGroup: Signal<string>;
  /** The topic whose messages are shown. */
  readonly topic: Signal<string>;
  /** The topic whose pictures are shown. */
  readonly pictured: Signal<string>;
  readonly lines: LinesState;
  readonly fields: FieldsState;
  /** Plot a number of a topic's messages, by its path. */
  readonly onPlot: (topic: string, field: string) => void;
  /** The interval that all plots show. */
  readonly zoom: Signal<Span | null>;
  readonly scans: ScanSeriesState;
  /** Start SLAM of the log, and open the group that shows it. */
  readonly onCorrectPoses: () => void;
  readonly notes: NotesState;
  /** The errors whose paths are on the map. */
  readonly trajectoryErrors: Signal<TrajectoryErrors | null>;
  /** The visible part of the map for a link; null for all of it. */
  readonly sharedView: () => SharedView | null;
  /** Other state of the page that a link contains. */
  readonly shown: () => Promise<Shown>;
}

interface Group {
  readonly id: string;
  readonly title: string;
  /** The section that it shares with neighbouring groups. */
  readonly section?: string;
  readonly keeps?: boolean;
  readonly isThere?: (view: LogView) => boolean;
  readonly badge?: (view: LogView) => string | null;
  readonly content: (view: LogView) => ComponentChildren;
}

const CostmapGroup = lazy(async () => (await import("../../tools/costmap/CostmapGroup")).CostmapGroup);

/** The group that is open at first. */
export const OVERVIEW = "overview";
/** The group of links. */
export const SHARE = "share";

const topicsOf = ({ store, sensor, log, isGuest, topic, openGroup }: LogView) => (
  <Topics
    key={log?.topic}
    store={store}
    sensor={isGuest ? null : sensor}
    log={log}
    onMessages={(name) => {
      topic.value = name;
      openGroup.value = "messages";
    }}
  />
);

const GROUPS: readonly Group[] = [
  {
    id: OVERVIEW,
    title: "Overview",
    section: "Log",
    badge: ({ doctor }) => findingsBadge(doctor),
    content: (view) => (
      <Overview
        store={view.store}
        scans={view.scans}
        doctor={view.doctor}
        zoom={view.zoom}
        {...(view.isGuest ? {} : { onCorrectPoses: view.onCorrectPoses })}
      >
        {topicsOf(view)}
      </Overview>
    ),
  },
  {
    id: "heal",
    title: "Heal",
    section: "Log",
    isThere: ({ log }) => log !== null,
    badge: ({ correction }) => correction.badge.value,
    content: ({ store, session, correction, comparison, doctor, isGuest }) => (
      <CorrectPoses {...{ store, session, correction, comparison, doctor, isGuest }} />
    ),
  },
  {
    id: "compare",
    title: "Compare",
    section: "Log",
    badge: ({ comparison }) => (comparison.isOn.value ? "on" : null),
    content: ({ store, session, comparison, isGuest }) => (
      <Compare store={store} session={session} comparison={comparison} isGuest={isGuest} />
    ),
  },
  {
    id: "trajectories",
    title: "Trajectories",
    section: "Log",
    content: ({ store, session, isGuest, trajectoryErrors }) => (
      <Trajectories store={store} session={session} isGuest={isGuest} errors={trajectoryErrors} />
    ),
  },
  {
    id: "notes",
    title: "Notes",
    section: "Log",
    badge: ({ notes }) => (notes.notes.value?.length ? String(notes.notes.value.length) : null),
    content: ({ store, session, notes, isGuest }) => (
      <Notes store={store} session={session} state={notes} isGuest={isGuest} />
    ),
  },
  {
    id: "settings",
    title: "Settings",
    keeps: true,
    content: ({ store, sensor, isGuest }) => <Settings store={store} sensor={isGuest ? null : sensor} />,
  },
  { id: "why", title: "Why", content: ({ store }) => <WhyGroup store={store} /> },
  {
    id: "localize",
    title: "Localize",
    section: "Navigate",
    isThere: ({ log }) => log !== null,
    badge: ({ localizing }) => localizing.badge.value,
    content: ({ store, localizing, isGuest }) => <Localize store={store} localizing={localizing} isGuest={isGuest} />,
  },
  {
    id: "costmap",
    title: "Costmap",
    section: "Navigate",
    isThere: ({ log }) => log !== null,
    content: ({ store, session, isGuest }) => (
      <CostmapGroup store={store}>{!isGuest && <TerrainChoice store={store} session={session} />}</CostmapGroup>
    ),
  },
  ...groupsOfParts("log", "Navigate").map((group) => ({ ...group, isThere: ({ log }: LogView) => log !== null })),
  {
    id: "topics",
    title: "Topics",
    section: "Data",
    content: topicsOf,
  },
  {
    id: "messages",
    title: "Messages",
    section: "Data",
    content: ({ store, session, topic, onPlot }) => (
      <Messages store={store} session={session} topic={topic} onPlot={onPlot} />
    ),
  },
  {
    id: "lines",
    title: "Log lines",
    section: "Data",
    content: ({ store, lines }) => <Lines store={store} lines={lines} />,
  },
  {
    id: "pictures",
    title: "Pictures",
    section: "Data",
    content: ({ store, session, pictured }) => <Pictures store={store} session={session} pictured={pictured} />,
  },
  {
    id: "plots",
    title: "Plots",
    section: "Data",
    content: ({ store, session, fields, zoom }) => (
      <Plots store={store} session={session} fields={fields} zoom={zoom} />
    ),
  },
  {
    id: "frames",
    title: "Frames",
    section: "Data",
    content: ({ store, session }) => <FrameTree store={store} session={session} />,
  },
  {
    id: "3d",
    title: "3D",
    content: ({ store, session }) => <PickingScene store={store} session={session} />,
  },
  {
    id: SHARE,
    title: "Link",
    section: "Share",
    isThere: ({ isGuest, log }) => !isGuest && log !== null,
    content: ({ session, sharedView, shown }) => <Share session={session} sharedView={sharedView} shown={shown} />,
  },
  {
    id: "download",
    title: "Download",
    section: "Share",
    content: ({ store, session, isGuest }) => (
      <Downloads session={session} title={store.hello.value?.title ?? "log"} isGuest={isGuest} />
    ),
  },
];

/** The groups of the dock in this view. */
export function groupsOf(view: LogView): readonly DockGroup[] {
  return GROUPS.filter((group) => group.isThere?.(view) ?? true).map(
    ({ id, title, section, keeps, badge, content }) => ({
      id,
      title,
      ...(section ? { section } : {}),
      keeps: keeps ?? false,
      badge: badge?.(view) ?? null,
      content: () => content(view),
    }),
  );
}
