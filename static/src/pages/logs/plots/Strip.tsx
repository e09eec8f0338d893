/** A low plot over the time of a log, one of a column with a common cursor and interval. */

import { effect, type ReadonlySignal, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import UPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { isDark } from "../../../ui/browser/theme";
import { useWidth } from "../../../ui/browser/useSize";
import { written } from "../../../ui/numbers";
import type { ScanSeries, SeriesColumn } from "../../../wire/http";
import { brokenAtGaps } from "../contents/gaps";
import {
  axisStyle,
  colourOf,
  drawLineAt,
  drawSelectedAt,
  labelsOn,
  numberLabels,
  onClickAt,
  rangeWith,
  timeAxis,
  zoomInto,
} from "../contents/plotParts";
import type { Span } from "../contents/series";
import type { Shown } from "./strips";

const HEIGHT = 56;
const AXIS_HEIGHT = 30;
const Y_AXIS_WIDTH = 52;

interface StripProps {
  readonly series: ScanSeries;
  readonly column: SeriesColumn;
  readonly shown: Shown;
  /** Colour role of its line. */
  readonly tone: string;
  /** The visible interval. */
  readonly span: Span;
  readonly zoom: Signal<Span | null>;
  /** The position of the pointer or the keyboard on the axis; null for none. */
  readonly pointed: Signal<number | null>;
  /** The position of the map's time. */
  readonly now: ReadonlySignal<number | null>;
  /** The positions of what is selected in all views. */
  readonly selected: ReadonlySignal<readonly number[]>;
  /** Whether the time axis is drawn below it. */
  readonly hasAxis: boolean;
  /** The time of the log's first scan, s since 1970, if the axis is in UTC; else null. */
  readonly start: number | null;
  readonly onGo: (place: number) => void;
}

export function Strip(props: StripProps) {
  const { series, column, shown, tone, span, zoom, pointed, now, selected, hasAxis, start, onGo } = props;
  const frame = useRef<HTMLDivElement>(null);
  const width = useWidth(frame, 600).value;
  const drawn = useRef<UPlot | null>(null);
  const scheme = isDark.value;
  const height = HEIGHT + (hasAxis ? AXIS_HEIGHT : 0);
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const moment = colourOf(element, "--beam");
    const chosen = colourOf(element, "--foreground");
    const axis = axisStyle(element);
    let isPointing = false;
    const options: UPlot.Options = {
      width,
      height,
      padding: [6, 8, hasAxis ? 0 : 4, 0],
      legend: { show: false },
      cursor: { ...zoomInto(zoom), y: false },
      scales: {
        x: { time: false, range: () => [span[0], span[1]] },
        y: { range: () => rangeWith(column.unit, shown.low, shown.high) },
      },
      axes: [
        {
          ...axis,
          size: hasAxis ? AXIS_HEIGHT : 0,
          ...(series.axis === "time"
            ? timeAxis(70, start)
            : { splits: labelsOn(70), values: (_: UPlot, splits: number[]) => splits.map((at) => written(at, 0)) }),
          gap: 3,
          ...(hasAxis ? {} : { values: () => [] }),
          ticks: { ...axis.ticks, show: hasAxis, size: 5 },
        },
        { ...axis, size: Y_AXIS_WIDTH, splits: labelsOn(22), gap: 4, values: (_, splits) => numberLabels(splits) },
      ],
      series: [
        {},
        {
          label: column.label,
          stroke: colourOf(element, tone),
          width: 1.5,
          ...brokenAtGaps(series, true),
        },
      ],
      hooks: {
        draw: [
          (chart) => {
            const at = now.peek();
            if (at !== null) drawLineAt(chart, at, moment);
            for (const place of selected.peek()) drawSelectedAt(chart, place, chosen);
          },
        ],
        setCursor: [
          (chart) => {
            // Only for the plot under the pointer; the others follow by the signal and by uPlot.
            if (!isPointing) return;
            const { left } = chart.cursor;
            pointed.value = left === undefined || left < 0 ? null : chart.posToVal(left, "x");
          },
        ],
        ready: [
          (chart) => {
            onClickAt(chart, onGo);
            chart.over.addEventListener("pointerenter", () => {
              isPointing = true;
            });
            chart.over.addEventListener("pointerleave", () => {
              isPointing = false;
              pointed.value = null;
            });
          },
        ],
      },
    };
    const limited = column.values.map((value) =>
      value === null ? null : Math.min(shown.high, Math.max(shown.low, value)),
    );
    const chart = new UPlot(options, [series.times as number[], limited], element);
    drawn.current = chart;
    const stops = [
      effect(() => {
        void [now.value, selected.value];
        chart.redraw(false);
      }),
      effect(() => {
        const at = pointed.value;
        if (isPointing) return;
        chart.setCursor({ left: at === null ? -10 : chart.valToPos(at, "x"), top: 0 }, false);
      }),
    ];
    return () => {
      for (const stop of stops) stop();
      drawn.current = null;
      chart.destroy();
    };
  }, [series, column, shown, tone, span, hasAxis, start, scheme]);
  useEffect(() => {
    drawn.current?.setSize({ width, height });
  }, [width, height]);
  return <div ref={frame} class="strip-plot" aria-hidden="true" style={{ height: `${height}px` }} />;
}
