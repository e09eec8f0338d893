/** Plots below the timeline of a log: motion and readings by scan, with the timeline's cursor. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useId, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { SwitchChip } from "../../../ui/dock/SwitchChip";
import { isInGap } from "../contents/gaps";
import { COMPUTED } from "../fields/fields";
import "./plots.css";
import { shownStart, shownTime } from "../../../store/shownTime";
import { StripRow } from "./StripRow";
import { keyedPlace, nearest, placeOfScan, scanAtPlace, shownRange, valueText, zoomedSpan } from "./strips";
import type { TimelinePlotsState } from "./timelinePlots";
import { type ScanSeriesState, useMoments, useUsed } from "./useScanSeries";

/** The initial plots; fewer in a small window, so that the map has room. */
const FIRST = ["speed", "turn rate", "turn", "returns", "pose step"];
const FIRST_IF_SMALL = ["speed", "turn", "returns"];
const isSmall = (): boolean => innerWidth < 704 || innerHeight < 800;

interface TimelinePlotsProps {
  readonly store: Store;
  readonly session: string;
  readonly state: TimelinePlotsState;
  readonly scans: ScanSeriesState;
}

export function TimelinePlots({ store, session, state, scans }: TimelinePlotsProps) {
  const { zoom } = state;
  const { series, failure, whole } = scans;
  useUsed(scans);
  const shown = useSignal<readonly string[]>(isSmall() ? FIRST_IF_SMALL : FIRST);
  const pointed = useSignal<number | null>(null);
  const trajectory = store.trajectory.value;
  const span = zoom.value;
  useEffect(() => {
    pointed.value = null; // the pointer has moved to another position
  }, [session, trajectory, span]);

  const axis = series.value?.axis ?? "time";
  const { now, selected } = useMoments(store, series);
  useSignalEffect(() => {
    const [index, trajectory] = [state.onTimeline.value, store.trajectory.peek()];
    if (!trajectory) return;
    pointed.value = index === null ? null : placeOfScan(series.peek()?.axis ?? "time", trajectory, index);
  });
  const scanAt = (place: number): number => {
    const trajectory = store.trajectory.peek();
    return trajectory ? scanAtPlace(axis, trajectory, place, store.frame.peek()?.count ?? 0) : 0;
  };
  useSignalEffect(() => {
    const at = pointed.value;
    state.inPlots.value = at === null || state.onTimeline.peek() !== null ? null : scanAt(at);
  });
  useEffect(
    () => () => {
      state.inPlots.value = null;
    },
    [state],
  );
  const go = (place: number): void => store.goTo(scanAt(place));

  const hint = useId();
  const values = series.value;
  const columns = useMemo(
    () => (values?.columns ?? []).map((column) => ({ column, range: shownRange(column.values) })),
    [values],
  );
  if (failure.value) return <p role="alert">{failure.value}</p>;
  if (!values) return <p class="quiet">…</p>;
  const visible = columns.filter(({ column }) => shown.value.includes(column.label));
  const interval = span ?? whole.value;
  const at = pointed.value ?? now.value;
  const isBetween = at !== null && isInGap(values.gaps, at);
  const row = at === null || isBetween ? -1 : nearest(values.times, at);
  const toggle = (label: string, isOn: boolean): void => {
    shown.value = isOn ? [...shown.peek(), label] : shown.peek().filter((other) => other !== label);
  };
  const zoomAround = (factor: number): void => {
    const middle = (interval[0] + interval[1]) / 2;
    const held = at !== null && at >= interval[0] && at <= interval[1] ? at : middle;
    zoom.value = zoomedSpan(interval, whole.peek(), held, factor);
  };
  const onKey = (event: KeyboardEvent): void => {
    if (event.target !== event.currentTarget || event.ctrlKey || event.metaKey || event.altKey) return;
    const moved = keyedPlace(event.key, event.shiftKey, at ?? interval[0], interval);
    if (moved !== null) pointed.value = moved;
    else if (event.key === "Enter" && pointed.peek() !== null) go(pointed.peek() ?? 0);
    else if (event.key === "+" || event.key === "=") zoomAround(0.5);
    else if (event.key === "-") zoomAround(2);
    else if (event.key === "Escape") {
      zoom.value = null;
      pointed.value = null;
    } else return;
    event.preventDefault();
  };
  const place =
    at === null
      ? ""
      : `${axis === "time" ? `${shownTime(store, at)}, ` : ""}scan ${scanAt(at)}${isBetween ? ", in a gap of the recording" : ""}`;
  const inWords = visible.map(({ column }) => `${column.label} ${valueText(column, column.values[row])}`).join("; ");
  return (
    <section class="timeline-plots" aria-label="Plots over the log">
      <div class="timeline-plots-head">
        <fieldset aria-label="What is plotted">
          {columns.map(({ column }) => (
            <SwitchChip
              key={column.label}
              label={column.label}
              checked={shown.value.includes(column.label)}
              title={COMPUTED[column.label] ?? ""}
              onChange={(isOn) => toggle(column.label, isOn)}
            />
          ))}
        </fieldset>
        <span id={hint} class="timeline-plots-hint">
          <span class="visually-hidden">Arrow keys move the cursor, Enter goes there, + and − zoom. </span>
          Click to go there, drag to zoom in.
        </span>
        <Button icon="plus" label="Zoom in on the moment" onClick={() => zoomAround(0.5)} />
        <Button
          icon="fit"
          label="Show the whole log"
          disabled={!span}
          onClick={() => {
            zoom.value = null;
          }}
        />
      </div>
      <div
        class="strips"
        role="slider"
        tabIndex={0}
        aria-label="Moment in the plots"
        aria-valuemin={interval[0]}
        aria-valuemax={interval[1]}
        aria-valuenow={at ?? interval[0]}
        aria-valuetext={at === null ? "No moment." : `${place}. ${inWords}`}
        aria-describedby={hint}
        onKeyDown={onKey}
        onBlur={() => {
          pointed.value = null;
        }}
      >
        {visible.map(({ column, range }, n) => (
          <StripRow
            key={column.label}
            value={column.values[row]}
            series={values}
            column={column}
            shown={range}
            span={interval}
            zoom={zoom}
            pointed={pointed}
            now={now}
            selected={selected}
            hasAxis={n === visible.length - 1}
            start={shownStart(store)}
            onGo={go}
          />
        ))}
        {visible.length === 0 && <p class="quiet">Choose what to plot.</p>}
      </div>
    </section>
  );
}
