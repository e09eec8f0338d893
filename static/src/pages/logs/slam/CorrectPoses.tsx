/** Corrects the poses of a log with SLAM, and shows and changes the pose graph that they come from. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import type { Comparison } from "../../../tools/compare/comparison";
import { Button } from "../../../ui/Button";
import { Panel } from "../../../ui/Panel";
import type { LogEvent } from "../../../wire/http";
import { compareWith } from "../compare/sides";
import { type DoctorState, Events, eventsOf } from "../Doctor";
import { JobProgress } from "../jobs/JobProgress";
import { ParameterDetails } from "../jobs/ParameterDetails";
import { trajectoryLabel } from "../library/describeLog";
import type { SlamStatus } from "./api";
import { Graph } from "./Graph";
import type { PoseCorrection } from "./poseCorrection";
import "./slam.css";
import { Merge } from "./Merge";
import { Score } from "./Score";

interface CorrectPosesProps {
  readonly store: Store;
  readonly session: string;
  readonly correction: PoseCorrection;
  readonly comparison: Comparison;
  readonly doctor: DoctorState;
  readonly isGuest: boolean;
}

export function CorrectPoses({ store, session, correction, comparison, doctor, isGuest }: CorrectPosesProps) {
  const job = correction.job.value;
  const trajectory = store.trajectory.value?.name ?? null;
  const isUnderWay = correction.isUnderWay.value;
  useEffect(() => correction.show(), [correction]);
  useEffect(() => {
    if (!isUnderWay && trajectory !== null) void correction.load();
  }, [correction, trajectory, isUnderWay]);
  const graph = correction.graph.value;
  return (
    <>
      {!isGuest && (
        <Panel title="Heal its poses">
          <div class="panel-stack">
            {!isUnderWay && (
              <p class="quiet">
                SLAM finds where the robot was from the scans themselves: it aligns each scan with those before it,
                closes a loop where the robot comes back to a place, and solves the graph of all poses.
              </p>
            )}
            <JobProgress
              of={correction}
              label="Healing"
              stage={(now) => STAGES[now.stage ?? ""] ?? beginning(now)}
              figures={(now) => (
                <>
                  {now.scans} of {store.frame.value?.count ?? 0} scans ·{" "}
                  <span class="loops-closed" key={now.loops}>
                    {now.loops} {now.loops === 1 ? "loop" : "loops"} closed
                  </span>
                </>
              )}
            />
            {job && !isUnderWay && <Outcome job={job} store={store} events={eventsOf(doctor)} />}
            {correction.failure.value !== null && (
              <p class="failure" role="alert">
                {correction.failure.value}
              </p>
            )}
            {!isUnderWay && <ParameterDetails parameters={correction.parameters} name="SLAM" titles={TITLES} />}
            {!isUnderWay && (
              <div class="actions">
                <Button
                  kind={job?.state === "done" ? undefined : "primary"}
                  disabled={correction.isBusy.value}
                  onClick={() => void correction.begin()}
                >
                  {job?.state === "done" ? "Heal again" : "Heal its poses"}
                </Button>
                <Results store={store} session={session} job={job} comparison={comparison} correction={correction} />
              </div>
            )}
          </div>
        </Panel>
      )}
      {graph && <Graph store={store} correction={correction} graph={graph} isGuest={isGuest} />}
      {!isGuest && <Merge store={store} session={session} comparison={comparison} />}
      {!isGuest && <Score store={store} session={session} />}
      {!graph && isGuest && <p class="quiet">The poses of this map have no pose graph.</p>}
    </>
  );
}

const TITLES: Readonly<Record<string, string>> = {
  scans: "Scans",
  "front end": "Each scan with those before it",
  loops: "Loops",
  graph: "Graph",
  refinement: "Refinement",
};

const STAGES: Readonly<Record<string, string>> = {
  "front end": "Aligning scans",
  "loop closure": "A loop has closed",
  comparison: "Aligning all scans again without recognized places, to compare both maps",
  refinement: "Aligning all scans together",
};

const LONG_S = 3;

/** Without compiled functions, a first report comes late. */
const beginning = (job: SlamStatus): string =>
  (job.elapsed_s ?? 0) < LONG_S ? "Beginning" : "Compiling SLAM, which this server does once";

interface OutcomeProps {
  readonly job: SlamStatus;
  readonly store: Store;
  /** Of the log, by the doctor. */
  readonly events: readonly LogEvent[];
}

/** What has become of a job: figures of the map, and what the wheels did not measure. */
export function Outcome({ job, store, events }: OutcomeProps) {
  if (job.state === "cancelled") return <p role="status">Healing was cancelled. The poses are those from before.</p>;
  if (job.state === "failed")
    return (
      <p class="failure" role="alert">
        {job.error?.message}
      </p>
    );
  const { result } = job;
  if (job.state !== "done" || !result) return null;
  return (
    <>
      <p role="status">Healed: the poses are the trajectory {trajectoryLabel(result.trajectory)} of this log.</p>
      <dl class="facts-list">
        <Figure name="drift" title="Drift of the walls" values={result.drift_m} form={metres} />
        <Figure name="contradicted" title="Contradicted readings" values={result.contradicted} form={percent} />
        <Figure
          name="sharpness"
          title="Sharpness of the walls"
          values={result.sharpness}
          form={(value) => value.toFixed(3)}
        />
        <dt>Began with</dt>
        <dd>{result.odometry === null ? "the scans alone" : trajectoryLabel(result.odometry)}</dd>
        <dt>Graph</dt>
        <dd>
          {result.nodes} poses, {result.loops} {result.loops === 1 ? "loop" : "loops"}
        </dd>
        <dt>Processor time</dt>
        <dd>{result.cpu_s.toFixed(1)} s</dd>
      </dl>
      {result.loops === 0 && (
        <p>No loop was found: the poses are as good as the alignment of each scan with those before it.</p>
      )}
      {events.length > 0 && <Events events={events} store={store} />}
      {result.notes.map((note) => (
        <p class="quiet" key={note}>
          {note}
        </p>
      ))}
    </>
  );
}

const metres = (value: number): string => `${value.toFixed(2)} m`;
const percent = (value: number): string => `${(100 * value).toFixed(1)} %`;

interface FigureProps {
  readonly name: string;
  readonly title: string;
  /** Before SLAM and now. */
  readonly values: readonly [number | null, number | null] | undefined;
  readonly form: (value: number) => string;
}

/** A figure of the map before SLAM and now; nothing where it is not known. */
function Figure({ name, title, values, form }: FigureProps) {
  if (!values) return null;
  const [before, after] = values;
  if (before === null && after === null) return null;
  const text = (value: number | null): string => (value === null ? "–" : form(value));
  return (
    <>
      <dt>{title}</dt>
      <dd data-figure={name} data-before={before} data-after={after}>
        {text(before)} before, {text(after)} now
      </dd>
    </>
  );
}

interface ResultsProps extends Omit<CorrectPosesProps, "doctor" | "isGuest"> {
  readonly job: SlamStatus | null;
}

/** Look at the map along the corrected poses, alone or beside the one from before. */
function Results({ store, session, job, comparison, correction }: ResultsProps) {
  const failure = useSignal<string | null>(null);
  const corrected = job?.state === "done" ? (job.result?.trajectory ?? null) : null;
  const names = (store.hello.value?.log?.trajectories ?? []).map((trajectory) => trajectory.name);
  if (corrected === null || !names.includes(corrected)) return null;
  const now = store.trajectory.value?.name;
  const before = correction.before.value ?? job?.result?.odometry ?? names.find((name) => name !== corrected);
  if (now !== corrected)
    return <Button onClick={() => store.send({ type: "trajectory", name: corrected })}>Show the healed map</Button>;
  if (before === undefined || before === corrected || !names.includes(before)) return null;
  return (
    <>
      <Button
        disabled={store.compared.value?.trajectory === before && comparison.isOn.value}
        onClick={async () => {
          comparison.mode.value = "swipe";
          failure.value = await compareWith(session, { trajectory: before });
        }}
      >
        Compare with before
      </Button>
      <Button kind="quiet" onClick={() => store.send({ type: "trajectory", name: before })}>
        Show {trajectoryLabel(before)}
      </Button>
      {failure.value !== null && (
        <p class="failure" role="alert">
          {failure.value}
        </p>
      )}
    </>
  );
}
