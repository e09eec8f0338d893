/** Numbers of the lab over its time, from when the view was opened. */

import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import UPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { Store } from "../../../store/store";
import { isDark } from "../../../ui/browser/theme";
import { useWidth } from "../../../ui/browser/useSize";
import { written } from "../../../ui/numbers";
import { axisStyle, colourOf, labelsOn, numberLabels, timeAxis } from "../../logs/contents/plotParts";
import { PLOTTED, Samples } from "./samples";
import "../stage.css";

const HEIGHT = 84;
/** Time between two paintings: as often as scans come at the usual speed. */
const EVERY_MS = 100;
const TONES = ["--miss", "--hit", "--robot", "--beam"] as const;

export function LabPlots({ store }: { readonly store: Store }) {
  const samples = useMemo(() => new Samples(), [store]);
  const version = useSignal(0);
  useEffect(() => {
    let painted = 0;
    let request = 0;
    // A scan's cells follow its frame, and are there with the next animation frame.
    const look = (now: number): void => {
      request = requestAnimationFrame(look);
      const [frame, map] = [store.frame.peek(), store.map.peek()];
      if (!frame || !map || now - painted < EVERY_MS || !samples.take(frame, map)) return;
      painted = now;
      version.value++;
    };
    request = requestAnimationFrame(look);
    return () => {
      cancelAnimationFrame(request);
      samples.stop();
    };
  }, [samples]);
  void version.value;
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
    <div class="lab-plots" tabIndex={0}>
      {PLOTTED.map(({ label, unit }, n) => (
        <Line key={label} samples={samples} version={version.value} column={n} label={label} unit={unit} />
      ))}
    </div>
  );
}

interface LineProps {
  readonly samples: Samples;
  /** Another number when there are other samples. */
  readonly version: number;
  readonly column: number;
  readonly label: string;
  readonly unit: string;
}

function Line({ samples, version, column, label, unit }: LineProps) {
  const frame = useRef<HTMLDivElement>(null);
  const drawn = useRef<UPlot | null>(null);
  const width = useWidth(frame, 360).value;
  const scheme = isDark.value;
  const values = samples.columns[column] ?? [];
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const axis = axisStyle(element);
    const chart = new UPlot(
      {
        width,
        height: HEIGHT,
        padding: [6, 8, 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26, ...timeAxis(60, null) },
          { ...axis, size: 52, splits: labelsOn(22), values: (_, splits) => numberLabels(splits) },
        ],
        series: [
          {},
          { stroke: colourOf(element, TONES[column] ?? "--foreground"), width: 1.5, points: { show: false } },
        ],
      },
      [samples.times, values],
      element,
    );
    drawn.current = chart;
    return () => {
      drawn.current = null;
      chart.destroy();
    };
  }, [samples, scheme]);
  useEffect(() => {
    drawn.current?.setSize({ width, height: HEIGHT });
  }, [width]);
  useEffect(() => {
    drawn.current?.setData([samples.times, values]);
  }, [version]);
  const now = values.findLast((value) => value !== null);
  return (
    <figure class="lab-plot" data-plot={label}>
      <figcaption>
        {label} <span class="number">{now == null ? "–" : `${written(now, unit === "cells" ? 0 : 2)} ${unit}`}</span>
      </figcaption>
      <div ref={frame} role="img" aria-label={`${label} over time, ${unit}`} />
    </figure>
  );
}
