import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Picture } from "../../render/picture/Picture";
import { CompareReadout } from "../../tools/compare/Readout";
import { useTool } from "../../tools/costmap/mapTool";
import { MapTools } from "../../tools/measure/MapTools";
import { BeliefView } from "../../tools/picture/BeliefView";
import { ComputingMap } from "../../tools/picture/ComputingMap";
import { Overview } from "../../tools/picture/Overview";
import { Readout } from "../../tools/readout/Readout";
import { usePicked } from "../../tools/scene/usePicked";
import { useOpenGroup } from "../../tools/why/useOpenGroup";
import { Dock } from "../../ui/dock/Dock";
import { LayoutChoice } from "../../ui/stage/LayoutChoice";
import { Stage, showView } from "../../ui/stage/Stage";
import { useLayout } from "../../ui/stage/useLayout";
import { toast } from "../../ui/Toast";
import type { TrajectoryErrors } from "../../wire/http";
import { SessionEnded } from "../SessionEnded";
import { useClass } from "../useClass";
import { useConnected } from "../useConnected";
import { comparisonFragment } from "./compare/link";
import { BothMaps, useComparison } from "./compare/useComparison";
import { ContentsContext, useContents } from "./contents/useContents";
import { eventsOf, useDoctor } from "./Doctor";
import { withField } from "./fields/fields";
import { useFieldsState } from "./fields/useFields";
import { groupsOf, OVERVIEW, SHARE } from "./groups";
import { Head } from "./Head";
import { openSession } from "./library/library";
import { useLines } from "./lines/useLines";
import { useLocalizing } from "./localize/localizing";
import { NoteCard, NotePins } from "./notes/NotePins";
import { useNotes } from "./notes/useNotes";
import { TimelinePlots } from "./plots/TimelinePlots";
import { useTimelinePlots } from "./plots/timelinePlots";
import { useScanSeries } from "./plots/useScanSeries";
import { useSensor } from "./sensor/useSensor";
import { applySharedView, applyShown, type GuestOfLink, sharedViewOf, shownOf } from "./share/shown";
import { CorrectionOffer } from "./slam/CorrectionOffer";
import { usePoseCorrection } from "./slam/poseCorrection";
import { Transport } from "./Transport";
import { ErrorPaths } from "./trajectories/ErrorPaths";
import { showColumn, ViewerFrame, ViewerStatus } from "./ViewerFrame";
import { Solid } from "./views/solid";
import { hasCamera, KINDS, lastLayout, MAP_ALONE, PLOTS_VIEW, presetsFor, viewsOf } from "./views/views";
import { OpenIn3d } from "./volume/OpenIn3d";

/** The number of scans in the map of a log whose session ended on the server, by its id: the next session goes there. */
const reached = new Map<string, number>();

interface ViewerProps {
  readonly session: string;
  /** Back to the logs; not for a guest. */
  readonly onClose?: () => void;
  /** The session has ended on the server: start another one on the same log. */
  readonly onGone: () => void;
  /** Whether to do so immediately. */
  readonly reopens?: boolean;
  /** Called with the topic when the session maps another sensor. */
  readonly onSensor?: (topic: string) => void;
  readonly guest?: GuestOfLink;
}

/** The view of one log: its map, playback, parameters, downloads. */
export function Viewer({ session, onClose, onGone, reopens = false, onSensor = () => undefined, guest }: ViewerProps) {
  const picture = useRef<Picture | null>(null);
  const stage = useRef<HTMLDivElement>(null);
  const connection = useConnected(session, { picture });
  const { store, status, trouble } = connection;
  const given = guest?.shown ?? null; // what a link shows to its guest
  const comparison = useComparison(session, store, given?.comparison);
  const doctor = useDoctor(store, session, guest !== undefined, guest?.examination);
  const correction = usePoseCorrection(store, session, guest !== undefined);
  const localizing = useLocalizing(store, session, guest !== undefined);
  const sensor = useSensor(session, onSensor);
  const notes = useNotes(session, store, given?.note ?? undefined);
  const plots = useTimelinePlots(given?.plots);
  const scans = useScanSeries(store, session, plots.zoom);
  const solid = useMemo(() => {
    const open = (ending: AbortSignal) =>
      openSession(store.hello.peek()?.log?.id ?? "", null, ending, { other: null, up: null });
    return new Solid({ session, store }, given?.scene ?? null, guest?.openClouds ?? open);
  }, [connection]);
  useEffect(() => solid.beginMap(), [solid]);
  const layout = useLayout({
    kinds: KINDS,
    usual: MAP_ALONE,
    linked: given?.layout ?? null,
    last: guest ? null : lastLayout,
  });
  const contents = useContents(session);
  const held = contents.state.value;
  const camera = hasCamera(held.kind === "ready" ? held.contents : null);
  const lines = useLines(session, store, contents, given?.lines);
  const fields = useFieldsState(session, given?.plots);
  const topic = useSignal(given?.message ?? ""); // the topic of the shown messages
  const pictured = useSignal(given?.picture ?? ""); // the topic of the shown pictures
  const trajectoryErrors = useSignal<TrajectoryErrors | null>(null);
  const openGroup = useOpenGroup(store, given?.group ?? OVERVIEW);
  const lastGroup = useRef(openGroup.peek()); // the group before that of links, in which a link is made
  if (openGroup.value !== SHARE) lastGroup.current = openGroup.value;
  const live = useMemo(() => (guest ? null : { ...connection, id: session }), [connection]);
  useClass(live, { page: "logs", group: openGroup });
  const openNotes = (): void => {
    showColumn();
    openGroup.value = "notes";
  };
  const onPlot = (topic: string, field: string): void => {
    fields.isNew.current = false;
    fields.chosen.value = withField(fields.chosen.peek(), { topic, field });
    if (layout.peek().views.includes(PLOTS_VIEW)) showView(PLOTS_VIEW);
    else {
      showColumn();
      openGroup.value = "plots";
    }
  };
  useSignalEffect(() => {
    if (status.value !== "gone" || !reopens) return;
    toast("The session had ended on the server. The log was opened again with default parameters.");
    const [log, frame] = [store.hello.peek()?.log, store.frame.peek()];
    if (log && frame) reached.set(log.id, frame.index);
    onGone();
  });
  useSignalEffect(() => {
    const id = store.hello.value?.log?.id ?? "";
    const index = reached.get(id);
    if (index === undefined || guest) return;
    reached.delete(id);
    store.goTo(index);
  });
  useSignalEffect(() => {
    const notice = store.notice.value;
    // The end of the log is visible without a message.
    if (notice && notice.code !== "log.end") toast(notice.message, notice.kind);
  });
  const hello = store.hello.value;

  useEffect(() => applySharedView(store, picture, guest?.view ?? null), [connection]);
  useEffect(() => (given ? applyShown(store, given, openGroup) : undefined), [connection]);
  const ended = status.value === "gone";
  useEffect(() => {
    if (ended) guest?.onEnded();
  }, [ended]);

  if (ended) {
    return (
      <SessionEnded
        left="The log is still there."
        again="Open the log again"
        onAgain={onGone}
        back="All logs"
        onBack={onClose}
      />
    );
  }
  const isGuest = guest !== undefined;
  const log = hello?.log ?? null;
  const openGraph = (): void => {
    showColumn();
    openGroup.value = "heal";
  };
  usePicked(store, {
    onLoop: (edge) => {
      openGraph();
      void correction.select(edge);
    },
    onPose: async (scan) => {
      if (await correction.selectPose(scan)) openGraph();
    },
  });
  const onCorrectPoses = (): void => {
    openGraph();
    void correction.begin();
  };
  const map = () => (
    <div class="viewer-map">
      <BeliefView
        store={store}
        comparison={comparison}
        takesTap={(point) =>
          localizing.takeTap(point) || (correction.takesTap.peek()?.(point) ?? false) || useTool(store, point)
        }
        onPicture={(made) => {
          picture.current = made;
        }}
      />
      <BothMaps store={store} comparison={comparison} />
      <ErrorPaths store={store} errors={trajectoryErrors} />
      <NotePins store={store} state={notes} onOpen={openNotes} />
      {isGuest && <NoteCard state={notes} />}
      <MapTools store={store} stage={stage} />
      <Overview store={store} />
      <ViewerStatus hello={hello} trouble={trouble.value} opening="Opening the log …" />
      <ComputingMap store={store} />
    </div>
  );
  return (
    <ContentsContext.Provider value={contents}>
      <ViewerFrame
        dock={
          <Dock
            label="About this log"
            groups={groupsOf({
              store,
              session,
              isGuest,
              log,
              comparison,
              doctor,
              correction,
              localizing,
              sensor,
              notes,
              trajectoryErrors,
              openGroup,
              topic,
              pictured,
              lines,
              fields,
              onPlot,
              zoom: plots.zoom,
              scans,
              onCorrectPoses,
              sharedView: () => sharedViewOf(store, picture),
              shown: () =>
                shownOf({
                  store,
                  group: lastGroup.current,
                  note: notes.chosen.peek(),
                  layout,
                  topic,
                  pictured,
                  fields,
                  lines,
                  plots,
                  solid,
                  comparison: comparisonFragment(store, comparison),
                }),
            })}
            open={openGroup}
          />
        }
      >
        <Head store={store} onClose={onClose}>
          {!isGuest && (
            <CorrectionOffer store={store} doctor={doctor} correction={correction} onCorrectPoses={onCorrectPoses} />
          )}
          {log && (
            <OpenIn3d id={isGuest ? null : log.id} contents={contents.state.value} solid={solid} layout={layout} />
          )}
          <LayoutChoice layout={layout} kinds={KINDS} presets={presetsFor(camera)} />
        </Head>
        <div class="viewer-stage" ref={stage}>
          <Stage
            views={viewsOf(
              { store, session, topic, pictured, comparison, lines, fields, onPlot, zoom: plots.zoom, solid },
              map,
            )}
            layout={layout.value}
            onLayout={(next) => {
              layout.value = next;
            }}
          />
          <Transport
            store={store}
            notes={notes}
            onNote={openNotes}
            events={eventsOf(doctor)}
            lines={lines}
            plots={plots}
          />
          {plots.isOpen.value && <TimelinePlots {...{ store, session, scans }} state={plots} />}
          <div class="viewer-readout">
            {comparison.isOn.value ? (
              <CompareReadout store={store} summedOver={comparison.summedOver.value} />
            ) : (
              <Readout store={store} />
            )}
          </div>
        </div>
      </ViewerFrame>
    </ContentsContext.Provider>
  );
}
