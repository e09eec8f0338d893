/** Any numeric fields of a recording over time. Those of IMU, odometry, battery and commands are preselected. */

import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { showAnswer } from "../../../ui/browser/attempts";
import { Failure } from "../../../ui/Failure";
import { SelectField } from "../../../ui/Select";
import { ask } from "../../../wire/ask";
import type { PlottedTopic, SeriesAnswer } from "../../../wire/http";
import { FieldPlot } from "../fields/FieldPlot";
import type { FieldsState } from "../fields/useFields";
import { Plot } from "./LazyPlot";
import type { Span } from "./series";
import { WhenKnown } from "./useContents";

interface PlotsProps {
  readonly store: Store;
  readonly session: string;
  readonly fields: FieldsState;
  /** The interval that all plots of the log show. */
  readonly zoom: Signal<Span | null>;
}

export function Plots({ store, session, fields, zoom }: PlotsProps) {
  return (
    <WhenKnown>
      {({ series }) => (
        <div class="plots">
          <FieldPlot key={store.trajectory.value?.name} store={store} session={session} fields={fields} zoom={zoom} />
          {series.length > 0 && <Topic store={store} session={session} series={series} zoom={zoom} />}
        </div>
      )}
    </WhenKnown>
  );
}

function Topic({
  store,
  session,
  series,
  zoom,
}: Omit<PlotsProps, "fields"> & { readonly series: readonly PlottedTopic[] }) {
  const chosen = useSignal(series[0]?.topic ?? "");
  const answer = useSignal<SeriesAnswer | null>(null);
  const failure = useSignal<string | null>(null);
  const topic = chosen.value;
  const span = zoom.value;
  useEffect(() => {
    if (answer.peek()?.topic !== topic) answer.value = null;
    const query = { topic, ...(span && { start: span[0], end: span[1] }) };
    const what = "GET /api/sessions/{session_id}/contents/series";
    return showAnswer(
      (ending) => ask(what, { session_id: session }, { query, ending }),
      failure,
      (series) => {
        answer.value = series;
      },
    );
  }, [session, topic, span]);
  const now = answer.value;
  return (
    <>
      <SelectField
        title="Topic"
        value={topic}
        options={series.map(({ topic, type }) => ({ value: topic, label: `${topic} (${type})` }))}
        onChange={(name) => {
          chosen.value = name;
        }}
      />
      <Failure why={failure.value} />
      {now === null && !failure.value && <p class="quiet">…</p>}
      {now !== null &&
        [...new Set(now.columns.map((column) => column.plot))].map((plot) => (
          <Plot key={`${now.topic} ${plot}`} store={store} series={now} plot={plot} zoom={zoom} />
        ))}
      <p class="quiet">
        {now !== null && now.samples > now.times.length
          ? `Of the ${now.samples.toLocaleString("en")} values ${span ? "in this interval" : "in the log"} the least and the greatest of each pixel. `
          : ""}
        The line is the moment of the map; a click goes to that moment, a drag zooms in, a double click zooms out.
      </p>
      {span && (
        <Button
          icon="fit"
          onClick={() => {
            zoom.value = null;
          }}
        >
          Show the whole log
        </Button>
      )}
    </>
  );
}
