/** Localizes the robot of a log in a reference map and shows the uncertainty over time. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useId, useMemo } from "preact/hooks";
import { momentText } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { AmclYaml } from "../../../tools/localization/AmclYaml";
import { MotionFan } from "../../../tools/localization/MotionFan";
import { GIVEN_MAP } from "../../../tools/localization/model";
import { SensorCurve } from "../../../tools/localization/SensorCurve";
import { Button } from "../../../ui/Button";
import { selected } from "../../../ui/bound";
import { Choice } from "../../../ui/Choice";
import { Failure } from "../../../ui/Failure";
import { OpenFiles } from "../../../ui/files/OpenFiles";
import { NumberField } from "../../../ui/NumberField";
import { Panel } from "../../../ui/Panel";
import { ProgressBar } from "../../../ui/ProgressBar";
import { SelectField } from "../../../ui/Select";
import { Toggle } from "../../../ui/Toggle";
import type { FilterHistory, LocalizationStatus, SeriesAnswer } from "../../../wire/http";
import type { Values } from "../../../wire/protocol";
import { Plot } from "../contents/LazyPlot";
import { JobProgress } from "../jobs/JobProgress";
import { ParameterDetails } from "../jobs/ParameterDetails";
import { type ChosenLog, LogChoice } from "../LogChoice";
import { trajectoryLabel } from "../library/describeLog";
import type { Localizing, MapSource } from "./localizing";
import "./localize.css";

interface FilterHistoryProps {
  readonly store: Store;
  readonly history: FilterHistory;
}

const PLOTS = ["Standard deviation of the place", "Entropy of the particles", "Fit of the scans"] as const;

/** The uncertainty of the poses in use over the log, beside the present scan. */
function HistoryOfFilter({ store, history }: FilterHistoryProps) {
  const series = useMemo(() => seriesOf(history), [history]);
  const now = store.part("localization").message.value;
  const first = history.first_converged;
  return (
    <Panel title="Along the way">
      <div class="panel-stack">
        <p>
          In <b>{history.map.title}</b>.{" "}
          {first === null
            ? "The particles never agreed on one place."
            : `The particles agree on one place from scan ${first + 1} on.`}
        </p>
        {first !== null && (
          <div class="actions">
            <Button onClick={() => store.goTo(first + 1)}>
              Go to {momentText(store, history.seconds[first] ?? 0, first + 1)}
            </Button>
            <Button kind="quiet" onClick={() => store.goTo(1)}>
              Go to the start, {momentText(store, history.seconds[0] ?? 0, 1)}
            </Button>
          </div>
        )}
        {now?.is_on && (
          <p class="localize-now" role="status">
            {now.is_converged ? (now.is_sure ? "Converged, sure" : "Converged, not sure") : "Not converged"} ·{" "}
            {now.n_particles.toLocaleString("en")} particles · {now.entropy.toFixed(1)} bit · fit {now.fit.toFixed(2)}
          </p>
        )}
        {PLOTS.map((plot) => (
          <Plot key={plot} store={store} series={series} plot={plot} />
        ))}
        <p class="quiet">
          On the map: the particles after the present scan, a sample of them, and the ellipse that has 95 % of the
          estimate’s density; it is dashed where the filter has not converged.
        </p>
      </div>
    </Panel>
  );
}

function seriesOf(history: FilterHistory): SeriesAnswer {
  return {
    topic: "localization",
    type: "",
    samples: history.seconds.length,
    gaps: [],
    times: history.seconds,
    columns: [
      { label: "deviation", unit: "m", plot: PLOTS[0], values: history.deviation_m },
      { label: "entropy", unit: "bit", plot: PLOTS[1], values: history.entropy },
      { label: "fit", unit: "", plot: PLOTS[2], values: history.fit },
    ],
  };
}

const FIELDS = [
  [0, "x", "m", 1],
  [1, "y", "m", 1],
  [2, "heading", "°", 180 / Math.PI],
] as const;

/** Of the fields, m or °. */
const STEP = 0.01;

/** The start of the robot: anywhere, or at a pose that is clicked on the map or entered. */
function InitialPose({ localizing }: { readonly localizing: Localizing }) {
  const pose = localizing.pose.value;
  const id = useId();
  return (
    <>
      <Choice
        label="The robot starts"
        options={[
          { value: "anywhere", label: "Anywhere" },
          { value: "pose", label: "At a pose" },
        ]}
        value={localizing.hasPose.value ? "pose" : "anywhere"}
        onChange={(value) => {
          localizing.hasPose.value = value === "pose";
          localizing.turns.value = false;
        }}
      />
      {localizing.hasPose.value && (
        <>
          <p role="status">
            {localizing.turns.value
              ? "Click on the map in the direction that the robot faces."
              : pose
                ? "Click on the map to place it again."
                : "Click on the map where it starts."}
          </p>
          <div class="localize-pose">
            {FIELDS.map(([i, name, unit, factor]) => (
              <div key={name} class="field">
                <label class="field-label" for={id + name}>
                  {name} ({unit})
                </label>
                <NumberField
                  id={id + name}
                  class="field-text number"
                  step={STEP}
                  value={pose ? pose[i] * factor : Number.NaN}
                  onChange={(value) => {
                    const next: [number, number, number] = [...(pose ?? ([0, 0, 0] as const))];
                    next[i] = value / factor;
                    localizing.pose.value = next;
                  }}
                />
              </div>
            ))}
          </div>
        </>
      )}
    </>
  );
}

interface LocalizeProps {
  readonly store: Store;
  readonly localizing: Localizing;
  readonly isGuest: boolean;
}

export function Localize({ store, localizing, isGuest }: LocalizeProps) {
  const trajectory = store.trajectory.value?.name ?? null;
  const isUnderWay = localizing.isUnderWay.value;
  useEffect(() => localizing.show(), [localizing]);
  useEffect(() => {
    if (!isGuest && !isUnderWay) void localizing.loadMap();
  }, [localizing, isGuest, isUnderWay]);
  useEffect(() => {
    if (!isUnderWay && trajectory !== null) void localizing.loadHistory();
  }, [localizing, trajectory, isUnderWay]);
  useSignalEffect(() => {
    store.givenPose.value = localizing.hasPose.value ? localizing.pose.value : null;
  });
  const history = localizing.history.value;
  const map = history?.map ?? localizing.map.value;
  return (
    <>
      {!isGuest && <Find store={store} localizing={localizing} />}
      {map && (
        <Toggle
          label="Show the reference map"
          sentence="The map to localize in, instead of the map made from this log’s scans."
          checked={store.underlay.value === GIVEN_MAP}
          disabled={false}
          onChange={(isOn) => {
            store.underlay.value = isOn ? GIVEN_MAP : null;
            store.viewHeld.value = false;
          }}
        />
      )}
      {history && <HistoryOfFilter store={store} history={history} />}
      {!history && isGuest && <p class="quiet">The poses of this map do not come from a localization.</p>}
    </>
  );
}

function Find({ store, localizing }: Omit<LocalizeProps, "isGuest">) {
  const job = localizing.job.value;
  const isUnderWay = localizing.isUnderWay.value;
  const doing = localizing.doing.value;
  const map = localizing.map.value;
  const names = (store.hello.value?.log?.trajectories ?? []).map((trajectory) => trajectory.name);
  const found = job?.result?.trajectory;
  const odometry = useSignal("");
  const sources = names.filter((name) => name !== found);
  return (
    <Panel title="Localize in a map">
      <div class="panel-stack">
        {!isUnderWay && (
          <>
            <p class="quiet">
              A particle filter finds the robot of this log in a map. Its poses become one more trajectory of the log.
            </p>
            <Outcome store={store} localizing={localizing} />
            <MapChoice store={store} localizing={localizing} />
            {doing !== null && (
              <div class="job-progress">
                <ProgressBar fraction={null} label={doing} />
                <p role="status">{doing} …</p>
              </div>
            )}
            {map && doing === null && (
              <p role="status">
                <b>{map.title}</b>
                <br />
                <span class="quiet">
                  {(map.cols * map.resolution).toFixed(1)} × {(map.rows * map.resolution).toFixed(1)} m, cells of{" "}
                  {Number((100 * map.resolution).toFixed(2))} cm
                </span>
                {map.notes.map((note) => (
                  <span class="map-note" key={note}>
                    {note}
                  </span>
                ))}
              </p>
            )}
          </>
        )}
        {map && !isUnderWay && (
          <>
            <InitialPose localizing={localizing} />
            {sources.length > 1 && (
              <Choice
                label="Odometry"
                sentence="The poses that say how the robot moved between two scans."
                options={[
                  { value: "", label: "The log’s own" },
                  ...sources.map((value) => ({ value, label: trajectoryLabel(value) })),
                ]}
                {...selected(odometry)}
              />
            )}
            <ParameterDetails
              parameters={localizing.parameters}
              name="the filter"
              titles={TITLES}
              figures={figuresOf(store, localizing)}
            >
              <AmclYaml
                values={() => localizing.parameters.changed()}
                onOpen={(values) => {
                  localizing.parameters.values.value = values;
                }}
              />
            </ParameterDetails>
          </>
        )}
        <JobProgress
          of={localizing}
          label="Localizing"
          stage={stageOf}
          figures={(now) =>
            `${now.scans} of ${store.frame.value?.count ?? 0} scans · ${now.n_particles.toLocaleString("en")} particles`
          }
        />
        <Failure class="failure" why={localizing.failure.value} />
        {map && !isUnderWay && (
          <div class="actions">
            <Button
              kind="primary"
              disabled={doing !== null || (localizing.hasPose.value && localizing.pose.value === null)}
              onClick={() => void localizing.begin(odometry.peek() || null)}
            >
              {job?.state === "done" ? "Find the robot again" : "Find the robot"}
            </Button>
          </div>
        )}
      </div>
    </Panel>
  );
}

/** The maximum range in the figure of the sensor model if the log does not state it, m. */
const LONGEST = 12;

/** The sensor model and the motion model as draggable curves. */
function figuresOf(store: Store, { parameters }: Localizing) {
  const rows = parameters.table.value;
  if (rows.length === 0) return {};
  const values = { ...Object.fromEntries(rows.map((row) => [row.name, row.initial])), ...parameters.values.value };
  const said = store.frame.value?.range_max ?? LONGEST;
  const set = (changed: Values): void => {
    for (const [name, value] of Object.entries(changed)) parameters.set(name, value);
  };
  return {
    sensor: (
      <SensorCurve
        values={values}
        rows={rows}
        range_max={Number.isFinite(said) && said > 0 ? said : LONGEST}
        set={set}
      />
    ),
    motion: <MotionFan values={values} />,
  };
}

const TITLES: Readonly<Record<string, string>> = {
  sensor: "Sensor model",
  motion: "Motion model",
  filter: "Filter",
  recovery: "Recovery",
  "global start": "Start without a hint",
};

const SOURCES: readonly { readonly value: MapSource; readonly label: string }[] = [
  { value: "own", label: "This log" },
  { value: "other", label: "Another log or map" },
  { value: "files", label: "Map files" },
];

function MapChoice({ store, localizing }: Omit<LocalizeProps, "isGuest">) {
  const log = store.hello.value?.log;
  const chosen = useSignal<ChosenLog | null>(null);
  const names = (log?.trajectories ?? []).map((trajectory) => trajectory.name);
  const along = useSignal("");
  // The poses that the page shows, except those of an earlier localization.
  const shown = store.trajectory.value?.name;
  const isUsual = shown !== undefined && shown !== localizing.job.value?.result?.trajectory && names.includes(shown);
  const mappedAlong = along.value || (isUsual ? shown : names[0]) || "";
  const isBusy = localizing.doing.value !== null;
  const source = localizing.source.value;
  return (
    <>
      <Choice
        label="The map"
        options={SOURCES}
        value={source}
        disabled={isBusy}
        onChange={(value) => {
          localizing.source.value = value;
        }}
      />
      {source === "own" && log && (
        <div class="localize-own">
          <SelectField
            title="Mapped along"
            value={mappedAlong}
            disabled={isBusy}
            options={names.map((name) => ({ value: name, label: trajectoryLabel(name) }))}
            onChange={(name) => {
              along.value = name;
            }}
          />
          <Button
            disabled={isBusy}
            onClick={() => void localizing.chooseLog(log.id, log.topic ?? null, mappedAlong || null)}
          >
            Use this map
          </Button>
        </div>
      )}
      {source === "other" && (
        <LogChoice
          withMaps
          own={log?.id ?? ""}
          chosen={chosen.value}
          disabled={isBusy}
          onChoose={(choice) => {
            chosen.value = choice;
            void localizing.chooseLog(choice.log, choice.topic, null);
          }}
        />
      )}
      {source === "files" && (
        <div class="localize-own">
          <OpenFiles
            label="Map files"
            multiple
            disabled={isBusy}
            onFiles={(files) => void localizing.chooseFiles(files)}
          >
            Choose map files
          </OpenFiles>
          <span class="quiet">A YAML file with its image, or a map of the CMU course.</span>
        </div>
      )}
    </>
  );
}

const LONG_S = 3;

function stageOf(job: LocalizationStatus): string {
  if (job.scans === 0)
    return (job.elapsed_s ?? 0) < LONG_S ? "Beginning" : "Compiling the filter, which this server does once";
  return job.is_converged ? "The particles agree on one place" : "The particles do not agree yet";
}

function Outcome({ store, localizing }: Omit<LocalizeProps, "isGuest">) {
  const job = localizing.job.value;
  if (job?.state === "cancelled")
    return <p role="status">Localization was cancelled. The poses are those from before.</p>;
  if (job?.state === "failed") return <Failure class="failure" why={job.error?.message} />;
  const result = job?.state === "done" ? job.result : null;
  if (!result) return null;
  const count = store.frame.value?.count ?? 0;
  const isThere = (store.hello.value?.log?.trajectories ?? []).some(
    (trajectory) => trajectory.name === result.trajectory,
  );
  return (
    <>
      <p role="status">
        {result.first_converged === null
          ? "The particles never agreed on one place: the position of the robot is not known."
          : result.is_converged
            ? `${result.is_sure ? "Found" : "Perhaps found"}: the poses in the map are the trajectory “localized” of this log.`
            : "Found and lost again: at the end the particles do not agree."}
      </p>
      <dl class="facts-list">
        <dt>In the map</dt>
        <dd>{result.map_title}</dd>
        <dt>Converged</dt>
        <dd>
          {result.first_converged === null ? "never" : `from scan ${result.first_converged + 1} on`}, at{" "}
          {result.converged} of {count} scans
        </dd>
        <dt>Sure</dt>
        <dd>
          {result.sure === 0
            ? "at no scan: the scans fit other places of the map nearly as well, or contradict it"
            : `at ${result.sure} scans, where other places were ruled out`}
        </dd>
        {result.left_out > 0 && (
          <>
            <dt>Left out</dt>
            <dd>{result.left_out} scans, whose poses are not known: no map along these poses has them</dd>
          </>
        )}
        <dt>Fit of the scans</dt>
        <dd>{result.median_fit.toFixed(2)} of 1, median</dd>
        <dt>Processor time</dt>
        <dd>{result.cpu_s.toFixed(1)} s</dd>
      </dl>
      {isThere && store.trajectory.value?.name !== result.trajectory && (
        <div class="actions">
          <Button onClick={() => store.send({ type: "trajectory", name: result.trajectory })}>
            Show the poses in the map
          </Button>
        </div>
      )}
    </>
  );
}
