/** A plot over time, or of quantities over another one, drawn by uPlot. */

import { effect, type Signal, untracked } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import UPlot from "uplot";
import { shownStart } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { isDark } from "../../../ui/browser/theme";
import { useWidth } from "../../../ui/browser/useSize";
import { written } from "../../../ui/numbers";
import { timeText } from "../../../ui/text/timeText";
import type { Plotted, PlottedColumn } from "../fields/fields";
import { nearest } from "../plots/strips";
import { scansAt, selectedMoments } from "../time/scanTimes";
import { brokenAtGaps, isInGap } from "./gaps";
import {
  axisStyle,
  colourOf,
  DRAG_PX,
  drawLineAt,
  drawSelectedAt,
  labelsOn,
  numberLabels,
  onClickAt,
  rangeWith,
  timeAxis,
  zoomInto,
} from "./plotParts";
import { type Span, scanAtTime } from "./series";
import "uplot/dist/uPlot.min.css";

/** The minimum and the maximum, slightly apart if all values are equal. */
function rangeOf(values: readonly (number | null)[]): [number, number] {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const value of values) {
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return [0, 1];
  const margin = 0.04 * (high - low) || Math.abs(low) * 0.05 || 0.5;
  return [low - margin, high + margin];
}

/** Options of a plot over time, changed for a plot over another column. A click goes to the time of a pair. */
function overEachOther(
  options: UPlot.Options,
  store: Store,
  element: HTMLElement,
  times: readonly number[],
  over: PlottedColumn,
  columns: readonly PlottedColumn[],
): UPlot.Options {
  const { axes = [], series = [], scales = {} } = options;
  const range = rangeWith(over.unit, ...rangeOf(over.values));
  const [now, selected] = [colourOf(element, "--beam"), colourOf(element, "--foreground")];
  const path = (chart: UPlot, line: number): UPlot.Series.Paths => {
    const stroke = new Path2D();
    let isDown = false;
    columns[line - 1]?.values.forEach((value, n) => {
      const x = over.values[n] ?? null;
      if (value === null || x === null) {
        isDown = false;
        return;
      }
      const point = [chart.valToPos(x, "x", true), chart.valToPos(value, scaleAt(chart, line), true)] as const;
      if (isDown) stroke.lineTo(...point);
      else stroke.moveTo(...point);
      isDown = true;
    });
    return { stroke, fill: null, clip: null, gaps: null, band: null, flags: 1 } as unknown as UPlot.Series.Paths;
  };
  /** The pair nearest to a point of the plot, px. */
  const nearestPair = (chart: UPlot, line: number, left: number, top: number): number | null => {
    let [best, least]: [number | null, number] = [null, Number.POSITIVE_INFINITY];
    columns[line - 1]?.values.forEach((value, n) => {
      const x = over.values[n] ?? null;
      if (value === null || x === null) return;
      const distance = Math.hypot(chart.valToPos(x, "x") - left, chart.valToPos(value, scaleAt(chart, line)) - top);
      if (distance < least) [best, least] = [n, distance];
    });
    return best;
  };
  /** The pairs at a time, one on each line. */
  const dotsAt = (chart: UPlot, at: number): Path2D[] => {
    const n = Math.max(
      0,
      times.findLastIndex((time) => time <= at),
    );
    return columns.flatMap(({ values }, line) => {
      const [x, y] = [over.values[n] ?? null, values[n] ?? null];
      if (x === null || y === null) return [];
      const place = [chart.valToPos(x, "x", true), chart.valToPos(y, scaleAt(chart, line + 1), true)] as const;
      const dot = new Path2D();
      dot.arc(...place, 5 * devicePixelRatio, 0, 2 * Math.PI);
      return [dot];
    });
  };
  return {
    ...options,
    height: 300,
    cursor: {
      drag: { x: false, y: false },
      points: { size: 6 },
      dataIdx: (chart, line) => {
        const { left = -1, top = -1 } = chart.cursor;
        return left < 0 ? null : nearestPair(chart, Math.max(1, line), left, top);
      },
    },
    scales: { ...scales, x: { time: false, range: () => range } },
    axes: axes.map((axis, n) =>
      n === 0
        ? {
            ...axisStyle(element),
            size: 40,
            splits: labelsOn(50),
            values: (_, splits) => numberLabels(splits),
            label: [over.label, over.unit].filter(Boolean).join(", "),
            labelSize: 16,
            labelFont: axis.font as string,
          }
        : axis,
    ),
    series: series.map((line, n) =>
      n === 0
        ? {
            ...line,
            label: over.label,
            value: (_, at) => (at === null ? "–" : `${Number(at.toPrecision(6))} ${over.unit}`),
          }
        : { ...line, paths: path, dash: [], points: { show: false } },
    ),
    hooks: {
      ...options.hooks,
      draw: [
        (chart) => {
          const at = store.frame.peek()?.stamp;
          if (at !== undefined) for (const dot of dotsAt(chart, at)) paint(chart, dot, "fill", now);
          for (const { seconds } of untracked(() => selectedMoments(store)))
            for (const dot of dotsAt(chart, seconds)) paint(chart, dot, "stroke", selected);
        },
      ],
      ready: [
        (chart) =>
          chart.over.addEventListener("click", () => {
            const { left = -1, top = -1 } = chart.cursor;
            const n = left < 0 ? null : nearestPair(chart, 1, left, top);
            const [time, way] = [times[n ?? -1], store.trajectory.peek()];
            if (time !== undefined && way) store.goTo(scansAt(way, time, store.frame.peek()?.count ?? 0));
          }),
      ],
    },
  };
}

/** Fill a dot, or draw its outline. */
function paint({ ctx }: UPlot, dot: Path2D, how: "fill" | "stroke", colour: string): void {
  ctx.save();
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx[`${how}Style`] = colour;
  ctx[how](dot);
  ctx.restore();
}

const scaleAt = (chart: UPlot, line: number): string => chart.series[line]?.scale ?? "y";

interface PlotProps {
  readonly store: Store;
  readonly series: Plotted;
  /** Which columns. */
  readonly plot: string;
  /**
   * The interval shown by several plots together; null for the whole log. Its owner fetches finer values when it
   * changes. Without it, a plot zooms into its present values.
   */
  readonly zoom?: Signal<Span | null>;
  /** The index of the column on the horizontal axis, instead of time. */
  readonly across?: number;
}

const HEIGHT = 150;
const ACROSS_HEIGHT = 300;
/** Colour roles and dashes of the lines; lines differ in both. */
const LINES: readonly { readonly tone: string; readonly dash: number[] }[] = [
  { tone: "--miss", dash: [] },
  { tone: "--hit", dash: [6, 3] },
  { tone: "--robot", dash: [2, 2] },
  { tone: "--beam", dash: [8, 3, 2, 3] },
  { tone: "--foreground", dash: [10, 4] },
];

export function Plot({ store, series, plot, zoom, across }: PlotProps) {
  const frame = useRef<HTMLDivElement>(null);
  const width = useWidth(frame, 360).value;
  const columns = series.columns.filter((column) => column.plot === plot);
  const units = [...new Set(columns.map((column) => column.unit))];
  const unit = units.join(", ");
  const scheme = isDark.value;
  const start = shownStart(store);
  const drawn = useRef<UPlot | null>(null);
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const over = across === undefined ? undefined : columns[across];
    const shown = over ? columns.filter((column) => column !== over) : columns;
    const made = optionsOf(store, element, series, shown, width, start);
    const options = {
      ...made,
      hooks: { ...made.hooks, setLegend: [(chart: UPlot) => showMoment(chart, store, series)] },
      cursor: {
        ...(zoom ? zoomInto(zoom) : CURSOR),
        // Fields of several topics have values at different times.
        dataIdx: (chart: UPlot, line: number, row: number) =>
          line === 0 ? row : nearestKnown(chart.data[line] ?? [], row),
      },
    };
    const chart = new UPlot(
      over ? overEachOther(options, store, element, series.times, over, shown) : options,
      [(over?.values ?? series.times) as number[], ...shown.map((column) => column.values as (number | null)[])],
      element,
    );
    drawn.current = chart;
    const span = zoom?.peek();
    if (span && !over) chart.setScale("x", { min: span[0], max: span[1] });
    const stop = effect(() => {
      void [store.frame.value, selectedMoments(store)];
      chart.redraw(false);
      showMoment(chart, store, series);
    });
    return () => {
      stop();
      drawn.current = null;
      chart.destroy();
    };
  }, [series, plot, scheme, across, start]);
  useEffect(() => {
    drawn.current?.setSize({ width, height: across === undefined ? HEIGHT : ACROSS_HEIGHT });
  }, [width, across]);
  const level = levelOf(columns.flatMap((column) => column.values));
  if (level !== null && across === undefined) {
    return (
      <figure class="plot" data-plot={plot}>
        <figcaption>{plot}</figcaption>
        <p class="quiet">
          {Number.isNaN(level) ? "There are no values." : `${Number(level.toFixed(3))} ${unit} throughout.`}
        </p>
      </figure>
    );
  }
  return (
    <figure class="plot" data-plot={plot}>
      <figcaption>{[plot, unit].filter(Boolean).join(", ")}</figcaption>
      <div ref={frame} role="img" aria-label={inWords(series, plot)} />
    </figure>
  );
}

/** For a plot that zooms into its present values. */
const CURSOR: UPlot.Cursor = {
  drag: { x: true, y: false, dist: DRAG_PX },
  points: { size: 6 },
  sync: { key: "log" },
};

/** While the pointer is over no plot, the legend states the values at the map's time. */
function showMoment(chart: UPlot, store: Store, { times, gaps }: Plotted): void {
  const at = store.frame.peek()?.stamp;
  if (at === undefined || (chart.cursor.left ?? -1) >= 0) return;
  const row = isInGap(gaps, at) ? -1 : nearest(times, at);
  const idxs = chart.data.map((values, line) => (row < 0 || line === 0 ? row : nearestKnown(values, row)));
  chart.setLegend({ idxs: idxs.map((one) => (one < 0 ? null : one)) }, false);
}

/** The nearest row with a value. */
function nearestKnown(values: ArrayLike<number | null | undefined>, row: number): number {
  for (let away = 0; away < values.length; away++) {
    if (values[row - away] != null) return row - away;
    if (values[row + away] != null) return row + away;
  }
  return row;
}

const [RIGHT, LEFT] = [1, 3]; // uPlot's numbers of the sides
const scaleOf = (unit: string): string => `y ${unit}`;
const scaleFor = (unit: string): UPlot.Scale => ({
  range: (_, low, high) => rangeWith(unit, ...(UPlot.rangeNum(low ?? 0, high ?? 1, 0.1, true) as [number, number])),
});
/** A number with six digits, because a value and its time can differ much in magnitude. */
const shortNumber = (value: number): string =>
  value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6) ? value.toPrecision(6) : written(value, 3);

/** The value that all have in common, NaN without any; null if they differ, so that a chart is worthwhile. */
function levelOf(values: readonly (number | null)[]): number | null {
  const known = values.filter((value) => value !== null);
  const first = known[0] ?? Number.NaN;
  return known.every((value) => value === first) ? first : null;
}

/** The range of each line, for screen readers. */
function inWords(series: Plotted, plot: string): string {
  const lines = series.columns
    .filter((column) => column.plot === plot)
    .map(({ label, unit, values }) => {
      const known = values.filter((value) => value !== null);
      if (known.length === 0) return `${label}: no values`;
      return `${label}: ${written(Math.min(...known), 2)} to ${written(Math.max(...known), 2)} ${unit}`;
    });
  return `${[series.topic, plot].filter(Boolean).join(", ") || "Fields"} over time. ${lines.join("; ")}.`;
}

function optionsOf(
  store: Store,
  element: HTMLElement,
  series: Plotted,
  columns: Plotted["columns"],
  width: number,
  start: number | null,
): UPlot.Options {
  const axis = axisStyle(element);
  const now = colourOf(element, "--beam");
  const selected = colourOf(element, "--foreground");
  const units = [...new Set(columns.map((column) => column.unit))];
  return {
    width,
    height: HEIGHT,
    legend: { show: true, live: true },
    // Each unit has a separate scale, alternately on the left and on the right.
    scales: { x: { time: false }, ...Object.fromEntries(units.map((unit) => [scaleOf(unit), scaleFor(unit)])) },
    axes: [
      { ...axis, size: 26, ...timeAxis(60, start) },
      ...units.map((unit, n) => ({
        ...axis,
        scale: scaleOf(unit),
        side: n % 2 === 0 ? LEFT : RIGHT,
        size: 52,
        splits: labelsOn(22),
        values: (_: UPlot, splits: number[]) => numberLabels(splits),
        grid: { ...axis.grid, show: n === 0 },
        ...(units.length > 1 ? { label: unit || "no unit", labelSize: 16, labelFont: axis.font as string } : {}),
      })),
    ],
    series: [
      { label: "time", value: (_, at) => (at === null ? "–" : timeText(at, start)) },
      ...columns.map((column, n) => {
        const line = LINES[n % LINES.length];
        return {
          label: column.label,
          scale: scaleOf(column.unit),
          stroke: colourOf(element, line?.tone ?? "--foreground"),
          width: 1.5,
          dash: line?.dash ?? [],
          ...(column.gaps
            ? brokenAtGaps({ times: series.times, gaps: [...column.gaps] }, true)
            : brokenAtGaps(series, false)),
          value: (_: UPlot, value: number | null) => (value === null ? "–" : `${shortNumber(value)} ${column.unit}`),
        };
      }),
    ],
    hooks: {
      draw: [
        (chart) => {
          const at = store.frame.peek()?.stamp;
          if (at !== undefined) drawLineAt(chart, at, now);
          for (const { seconds } of untracked(() => selectedMoments(store))) drawSelectedAt(chart, seconds, selected);
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
