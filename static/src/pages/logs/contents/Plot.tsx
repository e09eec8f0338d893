/** One plot over time, drawn by uPlot. */

import { effect, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import UPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { Store } from "../../../store/store";
import { isDark } from "../../../ui/browser/theme";
import { useWidth } from "../../../ui/browser/useWidth";
import { clock, written } from "../../../ui/numbers";
import type { SeriesAnswer } from "../../../wire/http";
import { brokenAtGaps } from "./gaps";
import { axisStyle, colourOf, DRAG_PX, drawLineAt, onClickAt, zoomInto } from "./plotParts";
import { type Span, scanAtTime } from "./series";

interface PlotProps {
  readonly store: Store;
  readonly series: SeriesAnswer;
  /** Which columns. */
  readonly plot: string;
  /**
   * The interval that is shown, of several plots together; null for the whole log. Whoever owns it fetches finer values
   * when it changes. Without it a plot zooms into the values that it has.
   */
  readonly zoom?: Signal<Span | null>;
}

const HEIGHT = 150;
/** Colour roles and dashes of the lines: lines are told apart by both. */
const LINES: readonly { readonly tone: string; readonly dash: number[] }[] = [
  { tone: "--miss", dash: [] },
  { tone: "--hit", dash: [6, 3] },
  { tone: "--robot", dash: [2, 2] },
];

export function Plot({ store, series, plot, zoom }: PlotProps) {
  const frame = useRef<HTMLDivElement>(null);
  const width = useWidth(frame, 360).value;
  const columns = series.columns.filter((column) => column.plot === plot);
  const unit = columns[0]?.unit ?? "";
  const scheme = isDark.value;
  const drawn = useRef<UPlot | null>(null);
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const chart = new UPlot(
      { ...optionsOf(store, element, series, columns, width), ...(zoom ? { cursor: zoomInto(zoom) } : {}) },
      [series.times as number[], ...columns.map((column) => column.values as (number | null)[])],
      element,
    );
    drawn.current = chart;
    const span = zoom?.peek();
    if (span) chart.setScale("x", { min: span[0], max: span[1] });
    const stop = effect(() => {
      void store.frame.value;
      chart.redraw(false);
    });
    return () => {
      stop();
      drawn.current = null;
      chart.destroy();
    };
  }, [series, plot, scheme]);
  useEffect(() => {
    drawn.current?.setSize({ width, height: HEIGHT });
  }, [width]);
  const level = levelOf(columns.flatMap((column) => column.values));
  if (level !== null) {
    return (
      <figure class="plot" data-plot={plot}>
        <figcaption>{plot}</figcaption>
        <p class="quiet">
          {Number.isNaN(level) ? "There are no values." : `${Number(level.toFixed(3))} ${unit} all the time.`}
        </p>
      </figure>
    );
  }
  return (
    <figure class="plot" data-plot={plot}>
      <figcaption>
        {plot}
        {unit && `, ${unit}`}
      </figcaption>
      <div ref={frame} role="img" aria-label={inWords(series, plot)} />
    </figure>
  );
}

/** The value that all have in common, NaN without any; null where they differ and are worth a chart. */
function levelOf(values: readonly (number | null)[]): number | null {
  const known = values.filter((value) => value !== null);
  const first = known[0] ?? Number.NaN;
  return known.every((value) => value === first) ? first : null;
}

/** The range of each line, for screen readers. */
function inWords(series: SeriesAnswer, plot: string): string {
  const lines = series.columns
    .filter((column) => column.plot === plot)
    .map(({ label, unit, values }) => {
      const known = values.filter((value) => value !== null);
      if (known.length === 0) return `${label}: no values`;
      return `${label}: ${written(Math.min(...known), 2)} to ${written(Math.max(...known), 2)} ${unit}`;
    });
  return `${series.topic}, ${plot} over time. ${lines.join("; ")}.`;
}

function optionsOf(
  store: Store,
  element: HTMLElement,
  series: SeriesAnswer,
  columns: SeriesAnswer["columns"],
  width: number,
): UPlot.Options {
  const axis = axisStyle(element);
  const now = colourOf(element, "--beam");
  return {
    width,
    height: HEIGHT,
    legend: { show: true, live: true },
    cursor: { drag: { x: true, y: false, dist: DRAG_PX }, points: { size: 6 }, sync: { key: "log" } },
    scales: { x: { time: false } },
    axes: [
      { ...axis, size: 26, values: (_, splits) => splits.map((at) => clock(at)), space: 60 },
      { ...axis, size: 52 },
    ],
    series: [
      { label: "time", value: (_, at) => (at === null ? "–" : `${written(at, 2)} s`) },
      ...columns.map((column, n) => {
        const line = LINES[n % LINES.length];
        return {
          label: column.label,
          stroke: colourOf(element, line?.tone ?? "--foreground"),
          width: 1.5,
          dash: line?.dash ?? [],
          ...brokenAtGaps(series, false),
          value: (_: UPlot, value: number | null) => (value === null ? "–" : written(value, 3)),
        };
      }),
    ],
    hooks: {
      draw: [
        (chart) => {
          const at = store.frame.peek()?.stamp;
          if (at !== undefined) drawLineAt(chart, at, now);
        },
      ],
      ready: [
        (chart) =>
          onClickAt(chart, (seconds) => {
            const trajectory = store.trajectory.peek();
            const count = store.frame.peek()?.count ?? 0;
            if (!trajectory) return;
            store.goTo(scanAtTime(trajectory, seconds, count));
          }),
      ],
    },
  };
}
