/** A plot of numbers over another number: a path through the pairs of each time, not sorted along the axis. */

import { untracked } from "@preact/signals";
import type UPlot from "uplot";
import type { Store } from "../../../store/store";
import type { PlottedColumn } from "../fields/fields";
import { scansAt, selectedMoments } from "../time/scanTimes";
import { axisStyle, colourOf, labelsOn, numberLabels, rangeWith } from "./plotParts";

/** The lowest and the highest value, a little apart where all are the same. */
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

/** Options of a plot over time, changed for values over those of another column; a click goes to the time of a pair. */
export function across(
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
  /** The pair that is nearest to a place of the plot, in px. */
  const nearest = (chart: UPlot, line: number, left: number, top: number): number | null => {
    let [best, least]: [number | null, number] = [null, Number.POSITIVE_INFINITY];
    columns[line - 1]?.values.forEach((value, n) => {
      const x = over.values[n] ?? null;
      if (value === null || x === null) return;
      const distance = Math.hypot(chart.valToPos(x, "x") - left, chart.valToPos(value, scaleAt(chart, line)) - top);
      if (distance < least) [best, least] = [n, distance];
    });
    return best;
  };
  /** The pairs at a time, each on its line. */
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
        return left < 0 ? null : nearest(chart, Math.max(1, line), left, top);
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
    series: series.map((one, n) =>
      n === 0
        ? {
            ...one,
            label: over.label,
            value: (_, at) => (at === null ? "–" : `${Number(at.toPrecision(6))} ${over.unit}`),
          }
        : { ...one, paths: path, dash: [], points: { show: false } },
    ),
    hooks: {
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
            const n = left < 0 ? null : nearest(chart, 1, left, top);
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
