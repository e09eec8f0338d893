/** Corrects the poses of a log with SLAM, and shows and edits the resulting pose graph. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import type { Comparison } from "../../../tools/compare/comparison";
import { Button } from "../../../ui/Button";
import { Failure } from "../../../ui/Failure";
import { OpenFiles } from "../../../ui/files/OpenFiles";
import { written } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import type { LogEvent } from "../../../wire/http";
import { compareWith } from "../compare/sides";
import { type DoctorState, Events, eventsOf } from "../Doctor";
import { JobProgress } from "../jobs/JobProgress";
import { ParameterDetails } from "../jobs/ParameterDetails";
import { trajectoryLabel } from "../library/describeLog";
import { type PoseScore, type SlamStatus, scorePoses } from "./api";
import { Graph } from "./Graph";
import { Merge } from "./Merge";
import type { PoseCorrection } from "./poseCorrection";
import "./slam.css";

interface Row {
  readonly name: string;
  readonly translation: number;
  readonly rotation: number | null;
  readonly count: number | null;
  readonly source: string | null;
}

/** The visitor's own rows and those of others, the best first. */
export function rowsOf(score: PoseScore): readonly Row[] {
  const own = [
    { name: trajectoryLabel(score.trajectory), figures: score.all },
    { name: `${trajectoryLabel(score.trajectory)}, unambiguous`, figures: score.unambiguous },
  ].flatMap(({ name, figures }) =>
    figures
      ? [
          {
            name,
            translation: figures.translation_m,
            rotation: figures.rotation_deg,
            count: figures.count,
            source: null,
          },
        ]
      : [],
  );
  const others = score.published.map(({ program, translation, rotation, count, source }) => ({
    name: program,
    translation,
    rotation,
    count,
    source,
  }));
  return [...own, ...others].sort((a, b) => a.translation - b.translation);
}

export function Score({ store, session }: { readonly store: Store; readonly session: string }) {
  const file = useSignal<File | null>(null);
  const score = useSignal<PoseScore | null>(null);
  const failure = useSignal<string | null>(null);
  const isBusy = useSignal(false);
  const trajectory = store.trajectory.value?.name ?? null;
  const chosen = file.value;
  useEffect(() => {
    if (!chosen || trajectory === null) return;
    let isCurrent = true;
    isBusy.value = true;
    failure.value = null;
    scorePoses(session, chosen)
      .then((scores) => {
        if (isCurrent) score.value = scores;
      })
      .catch((error: unknown) => {
        if (!isCurrent) return;
        score.value = null;
        failure.value = (error as Error).message;
      })
      .finally(() => {
        if (isCurrent) isBusy.value = false;
      });
    return () => {
      isCurrent = false;
    };
  }, [chosen, trajectory, session, isBusy, failure, score]);
  return (
    <Panel title="Score its poses">
      <div class="panel-stack">
        <p class="quiet">
          A file of relations states measured motions between places of a log (Kümmerle et al. 2009). The score is how
          far the poses are from them on average.
        </p>
        <div class="actions">
          <OpenFiles
            label="File of relations"
            disabled={isBusy.value}
            onFiles={([relations]) => {
              file.value = relations;
            }}
          >
            {chosen ? "Another file of relations" : "Choose a file of relations"}
          </OpenFiles>
        </div>
        {isBusy.value && <p role="status">Scoring {trajectoryLabel(trajectory ?? "")} …</p>}
        <Failure class="failure" why={failure.value} />
        {score.value && !isBusy.value && <Table score={score.value} />}
      </div>
    </Panel>
  );
}

/** Author and year, or who measured it: the part before the title or the log. */
const shortSource = (source: string): string => source.split(/[,:]/, 1)[0] ?? source;

function Table({ score }: { readonly score: PoseScore }) {
  const rows = rowsOf(score);
  const sources = [...new Set(rows.flatMap(({ source }) => (source === null ? [] : [source])))];
  return (
    <>
      <table class="score-table">
        <caption>Mean errors of position, metres, and of rotation, degrees</caption>
        <thead>
          <tr>
            <th scope="col">Poses</th>
            <th scope="col">m</th>
            <th scope="col">°</th>
            <th scope="col">relations</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(({ name, translation, rotation, count, source }) => (
            <tr key={name} class={source === null ? "score-own" : ""}>
              <th scope="row">
                {name}
                {source !== null && <small>{shortSource(source)}</small>}
              </th>
              <td>{written(translation, 4)}</td>
              <td>{rotation === null ? "–" : written(rotation, 2)}</td>
              <td>{count?.toLocaleString("en") ?? "–"}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class="quiet">
        {score.policy === "records"
          ? "Stamps of the relations are mapped to the log’s odometry messages in the order of its records; a relation is unambiguous if each of its stamps has one message."
          : "Poses are interpolated in time between the scans."}
        {score.left_out > 0 &&
          ` ${score.left_out} of ${score.relations} relations are left out: the log has no record of their times.`}
        {score.published.length === 0 && " The name of the file is not that of a log with published results."}
      </p>
      {sources.length > 0 && (
        <ul class="score-sources quiet">
          {sources.map((source) => (
            <li key={source}>{source}</li>
          ))}
        </ul>
      )}
    </>
  );
}

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
            <Failure class="failure" why={correction.failure.value} />
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
  /** Of the log, from the doctor. */
  readonly events: readonly LogEvent[];
}

/** The result of a job: figures of the map, and motion that the wheels did not measure. */
export function Outcome({ job, store, events }: OutcomeProps) {
  if (job.state === "cancelled") return <p role="status">Healing was cancelled. The poses are those from before.</p>;
  if (job.state === "failed") return <Failure class="failure" why={job.error?.message} />;
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

/** A figure of the map before SLAM and now; nothing if it is unknown. */
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

/** Show the map along the corrected poses, alone or beside the previous one. */
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
      <Failure class="failure" why={failure.value} />
    </>
  );
}
