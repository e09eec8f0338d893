import { type Signal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { shownStart } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import type { ScanSeries, SeriesColumn } from "../../../wire/http";
import { isInGap } from "../contents/gaps";
import type { Span } from "../contents/series";
import { StripRow } from "../plots/StripRow";
import { nearest, type Shown, scanAtPlace, shownRange } from "../plots/strips";
import { type ScanSeriesState, useMoments, useUsed } from "../plots/useScanSeries";

/** What is shown, each the first of which there are values: of a log without times there are no rates. */
const WANTED: readonly (readonly string[])[] = [["speed", "pose step"], ["turn rate", "turn"], ["returns"]];

interface Plotted {
  readonly column: SeriesColumn;
  readonly range: Shown;
}

/** The plots that tell something of a log: those whose values differ. */
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

/** How the robot moved and what its sensor saw over the time of the log. */
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
