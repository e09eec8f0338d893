/** A plot of any numeric fields of any topics, added by search, over time or over another field. */

import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { SwitchChip } from "../../../ui/dock/SwitchChip";
import { saveAs } from "../../../ui/files/saveAs";
import { ProgressBar } from "../../../ui/ProgressBar";
import { Select } from "../../../ui/Select";
import { Plot } from "../contents/LazyPlot";
import type { Span } from "../contents/series";
import {
  type Chosen,
  COMPUTED,
  csvOf,
  type Found,
  joined,
  keyOf,
  labelOf,
  type Made,
  matching,
  paired,
  SPEED,
  WINDOWS,
  withField,
} from "./fields";
import { type FieldsState, type FoundSeries, useFieldNames, useFieldSeries } from "./useFields";
import "./fields.css";

/** Number of listed matches of a search. */
const MOST = 30;

interface FieldPlotProps {
  readonly store: Store;
  readonly session: string;
  readonly fields: FieldsState;
  readonly zoom: Signal<Span | null>;
}

export function FieldPlot({ store, session, fields, zoom }: FieldPlotProps) {
  const chosen = fields.chosen.value;
  const across = chosen.length > 1 ? fields.across.value : null;
  const series = useFieldSeries(session, chosen, zoom.value, across !== null);
  const plotted = useMemo(() => {
    const ready = chosen.flatMap((item): Found[] => {
      const now = series.get(keyOf(item));
      return now?.kind === "ready" ? [{ chosen: item, series: now.value }] : [];
    });
    if (ready.length === 0) return null;
    return across === null ? joined(ready) : paired(ready, across);
  }, [chosen, series, across]);
  return (
    <section class="field-plot" aria-label="Plot of any field">
      <Search session={session} fields={fields} />
      {chosen.length > 0 && <Legend fields={fields} series={series} />}
      {plotted && (
        <div class="actions">
          <label>
            Horizontal{" "}
            <Select
              value={across ?? ""}
              options={[{ value: "", label: "time" }, ...(chosen.length > 1 ? chosen.map(keyOf) : [])]}
              onChange={(key) => {
                fields.across.value = key || null;
              }}
            />
          </label>
          <Button
            kind="quiet"
            icon="download"
            onClick={() =>
              saveAs(
                "plot.csv",
                new Blob([csvOf(plotted, store.hello.peek()?.log?.start_s ?? null)], { type: "text/csv" }),
              )
            }
          >
            CSV of what is shown
          </Button>
        </div>
      )}
      {plotted && (
        <Plot
          store={store}
          series={plotted}
          plot=""
          zoom={zoom}
          {...(across === null
            ? {}
            : { across: plotted.columns.findIndex((_, n) => isAcross(chosen, series, n, across)) })}
        />
      )}
    </section>
  );
}

/** Whether the n-th existing column belongs to the field on the horizontal axis. */
function isAcross(chosen: readonly Chosen[], series: FoundSeries, n: number, across: string): boolean {
  const there = chosen.filter((item) => series.get(keyOf(item))?.kind === "ready");
  const item = there[n];
  return item !== undefined && keyOf(item) === across;
}

function Search({ session, fields }: Pick<FieldPlotProps, "session" | "fields">) {
  const names = useFieldNames(session);
  const text = useSignal("");
  const topics = names.kind === "ready" ? names.value : [];
  const matches = useMemo(
    () => (text.value.trim() === "" ? [] : matching(topics, text.value, MOST)),
    [topics, text.value],
  );
  const add = (field: Pick<Chosen, "topic" | "field"> | undefined): void => {
    if (field) fields.chosen.value = withField(fields.chosen.peek(), field);
  };
  useEffect(() => {
    if (names.kind !== "ready" || !fields.isNew.current) return;
    fields.isNew.current = false;
    const isThere = topics.some(({ topic, fields: own }) => topic === SPEED.topic && own.includes(SPEED.field));
    if (isThere) add(SPEED);
  }, [names]);
  if (names.kind === "failed") return <p role="alert">{names.why}</p>;
  const recorded = topics.filter(({ computed }) => !computed);
  const without = recorded.filter(({ fields: own, why }) => own.length === 0 && why !== "");
  const count = recorded.reduce((sum, { fields: own }) => sum + own.length, 0);
  const isChosen = (field: Pick<Chosen, "topic" | "field">): boolean =>
    fields.chosen.value.some((other) => keyOf(other) === keyOf(field));
  return (
    <search class="field-search">
      <input
        class="field-text"
        type="search"
        aria-label="Add a field to the plot"
        placeholder="Add a field, for example: imu z"
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
        }}
        onKeyDown={(event) => {
          if (event.key !== "Enter") return;
          event.preventDefault();
          add(matches.find((field) => !fields.chosen.peek().some((other) => keyOf(other) === keyOf(field))));
        }}
      />
      {names.kind === "reading" && <ProgressBar fraction={names.progress > 0 ? names.progress : null} />}
      {text.value.trim() !== "" && names.kind === "ready" && (
        <ul class="field-matches" aria-label="Fields that match">
          {matches.map((field) => (
            <li key={keyOf(field)}>
              <button type="button" aria-pressed={isChosen(field)} onClick={() => add(field)}>
                <span class="quiet">{field.topic}</span> {field.field}
              </button>
            </li>
          ))}
          {matches.length === 0 && <li class="quiet">No field matches.</li>}
          {matches.length === MOST && <li class="quiet">More fields match: type more of the name.</li>}
        </ul>
      )}
      {text.value.trim() === "" && (
        <fieldset class="field-computed" aria-label="Computed from the log">
          {topics
            .filter(({ computed }) => computed)
            .flatMap(({ topic, fields: own }) => own.map((field) => ({ topic, field })))
            .map((item) => (
              <SwitchChip
                key={keyOf(item)}
                label={item.field}
                checked={isChosen(item)}
                title={COMPUTED[item.field] ?? ""}
                onChange={(isOn) => (isOn ? add(item) : remove(fields, keyOf(item)))}
              />
            ))}
        </fieldset>
      )}
      {names.kind === "ready" && fields.chosen.value.length === 0 && text.value === "" && (
        <p class="quiet">
          {count === 0
            ? "The recording has no other fields that can be plotted."
            : `${count.toLocaleString("en")} fields of ${recorded.length - without.length} topics. Enter adds the first match.`}
          {count === 0 && without[0] && ` ${without[0].why}`}
        </p>
      )}
    </search>
  );
}

function remove(fields: FieldsState, key: string): void {
  if (fields.across.peek() === key) fields.across.value = null;
  fields.chosen.value = fields.chosen.peek().filter((item) => keyOf(item) !== key);
}

function Legend({ fields, series }: { readonly fields: FieldsState; readonly series: FoundSeries }) {
  const change = (key: string, by: Partial<Chosen>): void => {
    fields.chosen.value = fields.chosen.peek().map((item) => (keyOf(item) === key ? { ...item, ...by } : item));
  };
  return (
    <ul class="field-legend" aria-label="Fields of the plot">
      {fields.chosen.value.map((item) => {
        const key = keyOf(item);
        const now = series.get(key);
        return (
          <li key={key} data-field={key}>
            <span class="field-name">
              <span class="quiet">{item.topic}</span> {item.field}
            </span>
            <Select
              label={`What is shown of ${key}`}
              value={item.made === "average" ? `average ${item.window}` : item.made}
              options={[
                "value",
                "derivative",
                ...WINDOWS.map((window) => ({ value: `average ${window}`, label: `mean of ${window} s` })),
              ]}
              onChange={(value) => {
                const [made, window] = value.split(" ");
                change(key, { made: made as Made, ...(window === undefined ? {} : { window: Number(window) }) });
              }}
            />
            <Button kind="quiet" icon="close" label={`Remove ${labelOf(item)}`} onClick={() => remove(fields, key)} />
            {(now === undefined || now.kind === "reading") && (
              <ProgressBar fraction={now?.kind === "reading" && now.progress > 0 ? now.progress : null} />
            )}
            {now?.kind === "failed" && <p role="alert">{now.why}</p>}
          </li>
        );
      })}
    </ul>
  );
}
