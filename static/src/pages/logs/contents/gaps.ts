/** Lines of a plot that are interrupted at gaps of the recording. */

import type UPlot from "uplot";
import type { SeriesAnswer } from "../../../wire/http";
import type { Span } from "./series";

type Gapped = Pick<SeriesAnswer, "times" | "gaps">;

/** Whether a position on the axis is inside a gap, not at one of its ends. */
export function isInGap(gaps: readonly Span[], at: number): boolean {
  return gaps.some(([from, to]) => at > from && at < to);
}

/** Intervals in ascending order, with overlapping ones merged. */
export function united(spans: readonly Span[]): [number, number][] {
  const gaps: [number, number][] = [];
  for (const [from, to] of [...spans].sort((a, b) => a[0] - b[0])) {
    const last = gaps[gaps.length - 1];
    if (last && from <= last[1]) last[1] = Math.max(last[1], to);
    else gaps.push([from, to]);
  }
  return gaps;
}

/** The rows with a value that no line reaches: single rows between two gaps, or between a gap and the end. */
export function isolatedRows({ times, gaps }: Gapped, values: readonly (number | null | undefined)[]): number[] {
  const rows: number[] = [];
  let gap = 0;
  let of = -1; // the gap before the present piece of the line
  let count = 0;
  times.forEach((time, row) => {
    if (values[row] == null) return;
    while (gap < gaps.length && (gaps[gap]?.[1] ?? 0) <= time) gap++;
    if (of === gap && count === 1) rows.pop();
    count = of === gap ? count + 1 : 1;
    of = gap;
    if (count === 1) rows.push(row);
  });
  return rows;
}

const valuesOf = (chart: UPlot, line: number) => (chart.data[line] ?? []) as readonly (number | null)[];

/** How uPlot draws a line of a series: interrupted at its gaps, and across missing values only if requested. */
export function brokenAtGaps(series: Gapped, spansMissing: boolean): Partial<UPlot.Series> {
  return {
    gaps: (chart, _line, _first, _last, missing) => {
      const gaps = series.gaps.map(
        ([from, to]): Span => [chart.valToPos(from, "x", true), chart.valToPos(to, "x", true)],
      );
      return united(spansMissing ? gaps : [...gaps, ...(missing as Span[])]);
    },
    points: {
      show: false,
      size: 4,
      filter: (chart, line) => (series.gaps.length > 0 ? isolatedRows(series, valuesOf(chart, line)) : null),
    },
  };
}
