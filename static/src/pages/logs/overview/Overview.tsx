import { type Signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useContext, useMemo } from "preact/hooks";
import { shownStart } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { written } from "../../../ui/numbers";
import { timeText } from "../../../ui/text/timeText";
import type { ScanSeries, SeriesColumn } from "../../../wire/http";
import type { LogInfo, Trajectory } from "../../../wire/protocol";
import { isInGap } from "../contents/gaps";
import type { Span } from "../contents/series";
import { ContentsContext } from "../contents/useContents";
import { Doctor, type DoctorState } from "../Doctor";
import { trajectoryLabel } from "../library/describeLog";
import { StripRow } from "../plots/StripRow";
import { nearest, type Shown, scanAtPlace, shownRange } from "../plots/strips";
import { type ScanSeriesState, useMoments, useUsed } from "../plots/useScanSeries";
import { UtcSwitch } from "../time/Moment";
import "../viewer.css";

/** The length of the path through the poses of a trajectory on this page, which may be a part of them, m. */
export function lengthOf({ poses }: Pick<Trajectory, "poses">): number {
  let sum = 0;
  let before = poses[0];
  for (const pose of poses) {
    if (before) sum += Math.hypot(pose[0] - before[0], pose[1] - before[1]);
    before = pose;
  }
  return sum;
}

const RECORDED = "Recorded";

const metres = (length: number): string => `${written(length, length < 100 ? 1 : 0)} m`;

/** The facts of a log as names and values. */
function factsOf(
  log: LogInfo,
  trajectory: Trajectory | null,
  extent: readonly number[] | null,
): readonly (readonly [string, string])[] {
  const length = trajectory ? lengthOf(trajectory) : 0;
  const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] = extent ?? [];
  const rate = log.duration_s > 0 ? (log.n_scans - 1) / log.duration_s : 0;
  return [
    ["Sensor", `${log.topic || "lidar"}, ${log.n_beams.toLocaleString("en")} beams`],
    ["Scans", `${log.n_scans.toLocaleString("en")}${rate > 0 ? `, ${written(rate, 1)} a second` : ", without times"}`],
    ...(log.duration_s > 0
      ? [
          [
            RECORDED,
            `${timeText(log.duration_s)}${log.start_s === null ? "" : `, from ${timeText(0, log.start_s)}`}`,
          ] as const,
        ]
      : []),
    ["Poses", `${trajectoryLabel(log.trajectory)}${length > 0 ? `, ${metres(length)} driven` : ""}`],
    ...(extent ? [["Map", `${metres(x1 - x0)} × ${metres(y1 - y0)}`] as const] : []),
    ["File", log.format],
  ];
}

export function Facts({ store }: { readonly store: Store }) {
  const log = store.hello.value?.log ?? null;
  const trajectory = store.trajectory.value;
  const extent = store.bounds.value;
  const now = log && trajectory ? { ...log, trajectory: trajectory.name } : log;
  const facts = useMemo(() => (now ? factsOf(now, trajectory, extent) : []), [log, trajectory, extent]);
  return (
    <dl class="log-facts" aria-label="Facts">
      {facts.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>
            {value} {name === RECORDED && (log?.start_s ?? null) !== null && <UtcSwitch label="Times in UTC" />}
          </dd>
        </div>
      ))}
    </dl>
  );
}

interface OverviewProps {
  readonly store: Store;
  readonly scans: ScanSeriesState;
  readonly doctor: DoctorState;
  /** Corrects the poses of the log; not for a guest. */
  readonly onCorrectPoses?: () => void;
  /** The interval that all plots show. */
  readonly zoom: Signal<Span | null>;
  /** The topics of a recording. */
  readonly children: ComponentChildren;
}

/** The first group of a log: its facts, its events, its motion, and its topics once they are known. */
export function Overview({ store, scans, doctor, onCorrectPoses, zoom, children }: OverviewProps) {
  const contents = useContext(ContentsContext)?.state.value;
  const hasTopics = contents?.kind === "ready" && contents.contents.topics.length > 0;
  return (
    <div class="log-overview">
      <Facts store={store} />
      <Doctor store={store} doctor={doctor} {...(onCorrectPoses ? { onCorrectPoses } : {})} />
      {store.trajectory.value && <Motion store={store} scans={scans} zoom={zoom} />}
      {hasTopics && (
        <section aria-label="Topics">
          <h2 class="doctor-title">Topics</h2>
          {children}
        </section>
      )}
    </div>
  );
}

/** The quantities shown, each the first that has values: a log without times has no rates. */
const WANTED: readonly (readonly string[])[] = [["speed", "pose step"], ["turn rate", "turn"], ["returns"]];

interface Plotted {
  readonly column: SeriesColumn;
  readonly range: Shown;
}

/** The plots with differing values. */
export function motionOf(columns: readonly SeriesColumn[]): readonly Plotted[] {
  return WANTED.flatMap((labels) => {
    const found = labels
      .map((wanted) => columns.find(({ label }) => label === wanted))
      .find((column) => column && new Set(column.values.filter((value) => value !== null)).size > 1);
    const range = found && shownRange(found.values);
    return range ? [{ column: found, range }] : [];
  });
}

interface MotionProps {
  readonly store: Store;
  readonly scans: ScanSeriesState;
  /** The interval that all plots show. */
  readonly zoom: Signal<Span | null>;
}

/** The motion of the robot and the returns of its sensor over the time of the log. */
export function Motion({ store, scans, zoom }: MotionProps) {
  const { series, whole } = scans;
  useUsed(scans);
  const { now, selected } = useMoments(store, series);
  const pointed = useSignal<number | null>(null);
  const found = series.value;
  const shown = useMemo(() => motionOf(found?.columns ?? []), [found]);
  if (!found || shown.length === 0) return null;
  const at = pointed.value ?? now.value;
  const row = at === null || isInGap(found.gaps, at) ? -1 : nearest(found.times, at);
  return (
    <section class="motion" aria-label="Motion">
      <h2 class="doctor-title">{found.axis === "time" ? "Over time" : "From scan to scan"}</h2>
      {shown.map(({ column, range }, n) => (
        <StripRow
          key={column.label}
          value={column.values[row]}
          series={found}
          column={column}
          shown={range}
          span={zoom.value ?? whole.value}
          zoom={zoom}
          pointed={pointed}
          now={now}
          selected={selected}
          hasAxis={n === shown.length - 1}
          start={shownStart(store)}
          onGo={(place) => store.goTo(scanOf(store, found, place))}
        />
      ))}
    </section>
  );
}

function scanOf(store: Store, { axis }: ScanSeries, place: number): number {
  const trajectory = store.trajectory.peek();
  return trajectory ? scanAtPlace(axis, trajectory, place, store.frame.peek()?.count ?? 0) : 0;
}
