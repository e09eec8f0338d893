import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useContext, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { written } from "../../../ui/numbers";
import { timeText } from "../../../ui/timeText";
import type { LogInfo, Trajectory } from "../../../wire/protocol";
import type { Span } from "../contents/series";
import { ContentsContext } from "../contents/useContents";
import { Doctor, type DoctorState } from "../Doctor";
import { trajectoryLabel } from "../library/describeLog";
import type { ScanSeriesState } from "../plots/useScanSeries";
import { UtcSwitch } from "../time/Moment";
import { Motion } from "./Motion";
import "../viewer.css";

/** The length of the path through the poses that the page has of a trajectory, which need not be all, m. */
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

/** The facts of a log: names, and values. */
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

/** What a log opens on: what it is, what happened in it, its motion, and its topics once they are known. */
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
