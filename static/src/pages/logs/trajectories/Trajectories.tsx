import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { selected } from "../../../ui/bound";
import { showAnswer } from "../../../ui/browser/attempts";
import { Choice } from "../../../ui/Choice";
import { Failure } from "../../../ui/Failure";
import { OpenFiles } from "../../../ui/files/OpenFiles";
import { written } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import { SelectField } from "../../../ui/Select";
import { ask } from "../../../wire/ask";
import type { TrajectoryErrors } from "../../../wire/http";
import type { LogInfo } from "../../../wire/messages";
import { Plot } from "../contents/LazyPlot";
import { trajectoryLabel } from "../library/describeLog";
import { addTrajectory, errorSeries, rowsOf, STATISTICS } from "./errors";
import { TrajectoryChoice } from "./TrajectoryChoice";
import "./trajectories.css";

/** A TUM file that is added to the log as a trajectory, by a button or dropped here. */
function AddTrajectory({ session }: { readonly session: string }) {
  const said = useSignal<{ readonly text: string; readonly isError: boolean } | null>(null);
  const busy = useSignal(false);
  const over = useSignal(false);
  const add = async (files: Iterable<File>): Promise<void> => {
    busy.value = true;
    for (const file of files) {
      try {
        said.value = { text: `${await addTrajectory(session, file)} was added.`, isError: false };
      } catch (error) {
        said.value = { text: (error as Error).message, isError: true };
      }
    }
    busy.value = false;
  };
  return (
    <section
      class={over.value ? "add-trajectory over" : "add-trajectory"}
      aria-label="Add a trajectory"
      onDragOver={(event) => {
        event.preventDefault();
        over.value = true;
      }}
      onDragLeave={() => {
        over.value = false;
      }}
      onDrop={(event) => {
        event.preventDefault();
        over.value = false;
        void add(event.dataTransfer?.files ?? []);
      }}
    >
      <OpenFiles label="TUM files" multiple disabled={busy.value} onFiles={(files) => void add(files)}>
        Add a TUM file
      </OpenFiles>
      <span class="quiet">or drop it here to add a trajectory to this log.</span>
      {said.value && <p role={said.value.isError ? "alert" : "status"}>{said.value.text}</p>}
    </section>
  );
}

const ALIGNMENTS = [
  { value: "rigid", label: "Least squares" },
  { value: "scaled", label: "With scale" },
  { value: "origin", label: "First pose" },
  { value: "none", label: "Not aligned" },
] as const;

interface TrajectoriesProps {
  readonly store: Store;
  readonly session: string;
  readonly isGuest: boolean;
  /** The present comparison, for the paths on the map. */
  readonly errors: Signal<TrajectoryErrors | null>;
}

/** The poses of the map, added trajectories, and the errors of one trajectory against another. */
export function Trajectories({ store, session, isGuest, errors }: TrajectoriesProps) {
  const log = store.hello.value?.log;
  return (
    <>
      <TrajectoryChoice store={store} />
      {!isGuest && log && <AddTrajectory session={session} />}
      <Panel title="Errors of one trajectory against another">
        {log?.compared ? (
          <Errors store={store} session={session} log={log} compared={log.compared} errors={errors} />
        ) : (
          <p class="quiet">The log has one trajectory: add another one to compare the two.</p>
        )}
      </Panel>
    </>
  );
}

function Errors({
  store,
  session,
  log: { trajectories },
  compared,
  errors,
}: Pick<TrajectoriesProps, "store" | "session" | "errors"> & {
  readonly log: LogInfo;
  readonly compared: readonly [reference: string, estimate: string];
}) {
  const names = trajectories.map(({ name }) => name);
  const options = names.map((name) => ({ value: name, label: trajectoryLabel(name) }));
  const reference = useSignal(compared[0]);
  const estimate = useSignal(compared[1]);
  const pathOf = (name: string): string => trajectories.find((trajectory) => trajectory.name === name)?.same_as ?? name;
  const align = useSignal<(typeof ALIGNMENTS)[number]["value"]>("rigid");
  const failure = useSignal<string | null>(null);
  const delta = useSignal(1);
  useEffect(() => {
    errors.value = null;
    const query = { reference: reference.value, estimate: estimate.value, align: align.value, delta: delta.value };
    const what = "GET /api/sessions/{session_id}/trajectory-errors";
    return showAnswer(
      (ending) => ask(what, { session_id: session }, { query, ending }),
      failure,
      (answer) => {
        errors.value = answer;
      },
    );
  }, [session, reference.value, estimate.value, align.value, delta.value]);
  useEffect(
    () => () => {
      errors.value = null; // the paths are on the map while the group is open
    },
    [],
  );
  const comparison = errors.value;
  return (
    <div class="errors">
      <SelectField title="Reference" {...selected(reference)} options={options} />
      <SelectField title="Compared with it" {...selected(estimate)} options={options} />
      <Choice label="Aligned by" options={ALIGNMENTS} {...selected(align)} />
      <Choice
        label="Relative error over"
        options={["0.5", "1", "5", "10"].map((value) => ({ value, label: `${value} m` }))}
        value={String(delta.value)}
        onChange={(value) => {
          delta.value = Number(value);
        }}
      />
      {pathOf(reference.value) === pathOf(estimate.value) && (
        <p class="quiet">These two are the same path, stated twice.</p>
      )}
      <Failure why={failure.value} />
      {!comparison && !failure.value && <p class="quiet">…</p>}
      {comparison && !failure.value && (
        <>
          <Table errors={comparison} />
          {(["absolute", "relative"] as const).map((which) => {
            const series = errorSeries(comparison, which);
            return series.columns.map(({ plot }) => (
              <Plot
                key={[reference.value, estimate.value, align.value, delta.value, plot].join(" ")}
                store={store}
                series={series}
                plot={plot}
              />
            ));
          })}
        </>
      )}
      <p class="quiet">
        On the map: both paths in the frame of the reference; the compared one is coloured by its absolute error. The
        definitions are those of evo and of <code>gridbloom evaluate</code>.
      </p>
    </div>
  );
}

function Table({ errors }: { readonly errors: TrajectoryErrors }) {
  return (
    <div class="errors-table">
      <table>
        <caption class="quiet">{errors.pairs} pairs of poses</caption>
        <thead>
          <tr>
            <th scope="col">Error</th>
            {STATISTICS.map((name) => (
              <th key={name} scope="col">
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rowsOf(errors).map(([what, unit, figures]) => (
            <tr key={what + unit}>
              <th scope="row">
                {what} ({unit})
              </th>
              {figures.map((value, n) => (
                <td key={STATISTICS[n]}>{written(value, value >= 100 ? 0 : value >= 10 ? 1 : 3)}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
