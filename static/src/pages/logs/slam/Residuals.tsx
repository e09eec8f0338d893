/** Agreement of a log's poses with the measurements: residuals of its pose graph, and errors between two paths. */

import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { showAnswer } from "../../../ui/browser/attempts";
import { Failure } from "../../../ui/Failure";
import { ProgressBar } from "../../../ui/ProgressBar";
import { ask } from "../../../wire/ask";
import type { TrajectoryErrors } from "../../../wire/http";
import { Plot } from "../contents/LazyPlot";
import type { Span } from "../contents/series";
import { WhenKnown } from "../contents/useContents";
import { type Chosen, type Found, joined, keyOf } from "../fields/fields";
import { useFieldNames, useFieldSeries } from "../fields/useFields";
import { trajectoryLabel } from "../library/describeLog";
import { errorSeries } from "../trajectories/errors";

interface ResidualsProps {
  readonly store: Store;
  readonly session: string;
  /** The interval that all plots of the log show. */
  readonly zoom: Signal<Span | null>;
}

const GRAPH = "(slam)";
const CONTRADICTED: Chosen = { topic: "(map)", field: "contradicted", made: "value", window: 1 };

export function Residuals(props: ResidualsProps) {
  const trajectory = props.store.trajectory.value?.name;
  return (
    <div class="plots">
      <WhenKnown>{() => <OfPoses key={trajectory} {...props} />}</WhenKnown>
      <OfPaths {...props} />
    </div>
  );
}

/** Residuals of the graph of the map's trajectory; without a graph, the readings that contradict the map. */
function OfPoses({ store, session, zoom }: ResidualsProps) {
  const names = useFieldNames(session);
  const fields = names.kind === "ready" ? names.value.find(({ topic }) => topic === GRAPH)?.fields : undefined;
  const isKnown = names.kind === "ready";
  const chosen = useMemo(
    (): readonly Chosen[] =>
      fields?.map((field) => ({ topic: GRAPH, field, made: "value", window: 1 })) ?? (isKnown ? [CONTRADICTED] : []),
    [fields, isKnown],
  );
  const series = useFieldSeries(session, chosen, zoom.value, false);
  const ready = useMemo(
    () =>
      chosen.flatMap((plot): Found[] => {
        const now = series.get(keyOf(plot));
        return now?.kind === "ready" ? [{ chosen: plot, series: now.value }] : [];
      }),
    [chosen, series],
  );
  const units = [...new Set(ready.flatMap(({ series: { columns } }) => columns.map(({ unit }) => unit)))];
  const plots = useMemo(
    () => units.map((unit) => joined(ready.filter(({ series: { columns } }) => columns[0]?.unit === unit))),
    [ready],
  );
  const failed = [...series.values(), names].find((answer) => answer.kind === "failed");
  return (
    <>
      {failed?.kind === "failed" && <p role="alert">{failed.why}</p>}
      {ready.length === 0 && !failed && <ProgressBar fraction={null} label="Reading the residuals" />}
      {plots.map((data, n) => (
        <Plot key={units[n]} store={store} series={data} plot="" zoom={zoom} />
      ))}
      {ready.length > 0 && (
        <p class="quiet">
          {fields
            ? "By how much the corrected poses miss the motion that was measured to each scan, and the loops that end there."
            : "These poses have no pose graph; SLAM (“Heal its poses”) makes one. Until then: the share of each scan’s readings that the whole log’s map contradicts."}
        </p>
      )}
    </>
  );
}

/** The relative error of two trajectories, initially SLAM and the wheels. */
function OfPaths({ store, session }: ResidualsProps) {
  const log = store.hello.value?.log;
  const [reference = "", estimate = ""] = log?.compared ?? [];
  const isPair = (log?.trajectories ?? []).filter(({ same_as }) => same_as === null).length > 1;
  const errors = useSignal<TrajectoryErrors | null>(null);
  const failure = useSignal<string | null>(null);
  useEffect(() => {
    errors.value = null;
    if (!isPair) return;
    const what = "GET /api/sessions/{session_id}/trajectory-errors";
    return showAnswer(
      (ending) =>
        ask(what, { session_id: session }, { query: { reference, estimate, align: "rigid", delta: 1 }, ending }),
      failure,
      (answer) => {
        errors.value = answer;
      },
    );
  }, [session, reference, estimate, isPair]);
  const series = useMemo(() => errors.value && errorSeries(errors.value, "relative"), [errors.value]);
  if (!isPair) return null;
  return (
    <>
      <p>
        <strong>{trajectoryLabel(estimate)}</strong> against {trajectoryLabel(reference)}, over 1 m
      </p>
      <Failure why={failure.value} />
      {series?.columns.map(({ plot }) => (
        <Plot key={plot} store={store} series={series} plot={plot} />
      ))}
    </>
  );
}
