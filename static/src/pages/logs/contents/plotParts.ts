/** What all plots over a log's time have in common: colours, axes, the map's time, zooming by a drag. */

import type { Signal } from "@preact/signals";
import type UPlot from "uplot";
import { labelFont } from "../../../style/colour";
import { clock } from "../../../ui/numbers";
import { timeText } from "../../../ui/text/timeText";
import type { Span } from "./series";

/** Horizontal distance from which a press is a drag, px. */
export const DRAG_PX = 6;

/** The colour of a role within an element, for a canvas. */
export function colourOf(element: HTMLElement, role: string): string {
  const probe = document.createElement("span");
  probe.style.color = `var(${role})`;
  element.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}

export function axisStyle(element: HTMLElement): UPlot.Axis {
  return {
    font: labelFont(),
    stroke: colourOf(element, "--foreground-soft"),
    grid: { stroke: colourOf(element, "--line"), width: 1 },
    ticks: { stroke: colourOf(element, "--line") },
  };
}

/** Steps of an axis of times, s: whole minutes and hours beyond a minute. */
export const TIME_STEPS: number[] = [
  ...[1e-3, 1e-2, 0.1].flatMap((step) => [step, 2 * step, 5 * step]),
  ...[1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400, 21_600, 43_200, 86_400],
];

/** Round steps of an axis of numbers that spans `length`. */
function roundSteps(length: number): number[] {
  const power = Math.floor(Math.log10(length)) - 2;
  return [0, 1, 2].flatMap((more) => [1, 2, 5].map((digit) => Number(`${digit}e${power + more}`)));
}

/** The multiples of `step` within an interval; null if there are more than `most`. */
function multiples(step: number, low: number, high: number, most: number): number[] | null {
  const [first, last] = [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
  if (last - first >= most) return null;
  return Array.from({ length: last - first + 1 }, (_, n) => Number(((first + n) * step).toPrecision(12)));
}

/**
 * Positions of the labels on an axis: multiples of one of the ascending `steps`, at least three and at most `most`.
 * Without `steps` they are round numbers. uPlot itself leaves one or two on a short axis.
 */
export function labelPlaces(low: number, high: number, most: number, steps?: readonly number[]): number[] {
  if (!(high > low)) return [low];
  let [finer, finerStep]: [number[], number] = [[], 0];
  for (const step of steps ?? roundSteps(high - low)) {
    const places = multiples(step, low, high, 20 * most);
    if (!places) continue;
    if (places.length <= most) {
      if (places.length >= 3) return places;
      // Four labels where only three have room and the next step leaves two, such as 0, 3, 6 instead of 0, 2, 4, 6 or
      // 0, 5.
      const between = steps || finerStep === 0 ? null : multiples(1.5 * finerStep, low, high, most);
      if (between && between.length >= 3) return between;
      const every = Math.floor((finer.length - 1) / 2);
      return every > 0 ? finer.filter((_, n) => n % every === 0).slice(0, 3) : [low, (low + high) / 2, high];
    }
    [finer, finerStep] = [places, step];
  }
  return finer;
}

/**
 * The labels that have room on the axis of a chart, at least `space` px apart. Labels of an axis in UTC are round if 0
 * on it is `origin`.
 */
export function labelsOn(space: number, steps?: number[], origin = 0): NonNullable<UPlot.Axis["splits"]> {
  return (chart, axis, low, high) => {
    const isAcross = chart.axes[axis]?.side === 0 || chart.axes[axis]?.side === 2;
    const length = (isAcross ? chart.bbox.width : chart.bbox.height) / devicePixelRatio;
    const most = Math.max(3, Math.floor(length / space));
    return labelPlaces(low + origin, high + origin, most, steps).map((at) => at - origin);
  };
}

/** The range of an axis of numbers. Shares of a whole do not exceed 1. */
export function rangeWith(unit: string, low: number, high: number): [number, number] {
  return unit === "%" ? [Math.max(0, low), Math.min(100, high)] : [low, high];
}

const PLAIN = new Intl.NumberFormat("en", { maximumSignificantDigits: 6 });
const COMPACT = new Intl.NumberFormat("en", { maximumSignificantDigits: 6, notation: "compact" });

/** Numbers on an axis; large ones such as 250K. */
export const numberLabels = (splits: readonly number[]): string[] =>
  splits.map((at) => (Math.abs(at) >= 1e5 ? COMPACT : PLAIN).format(at).replace("-", "−"));

/** The labels of an axis of times, s from the log's first scan, or in UTC if `start` is the time of that scan. */
export const timeAxis = (space: number, start: number | null): Pick<UPlot.Axis, "splits" | "values"> => ({
  // In UTC they need more room. The second of the day is the origin, because seconds since 1970 would need too many
  // digits.
  splits: labelsOn(start === null ? space : 1.3 * space, TIME_STEPS, (start ?? 0) % DAY_S),
  values: (_, splits) => timeLabels(splits, start),
});

const DAY_S = 86_400;

/** Times on an axis with the decimals that their spacing needs; in UTC at most to the millisecond. */
export function timeLabels(splits: readonly number[], start: number | null = null): string[] {
  const step = (splits[1] ?? 1) - (splits[0] ?? 0);
  const digits = step >= 1 - 1e-9 ? 0 : Math.min(6, Math.ceil(-Math.log10(step) - 1e-6));
  return splits.map((at) => {
    if (start !== null) return timeText(at, start).slice(11, digits > 0 ? 20 + Math.min(3, digits) : 19);
    const text = Math.abs(at).toFixed(digits);
    const seconds = Number(text);
    const rest = digits > 0 ? text.slice(text.indexOf(".")) : "";
    return `${at < 0 && seconds > 0 ? "−" : ""}${clock(Math.floor(seconds))}${rest}`;
  });
}

/** A vertical line over the height of a chart with the dash pattern `dash`, CSS pixels. */
export function drawLineAt(chart: UPlot, at: number, colour: string, dash: readonly number[] = []): void {
  const x = chart.valToPos(at, "x", true);
  const { left, top, width, height } = chart.bbox;
  if (x < left || x > left + width) return;
  chart.ctx.save();
  chart.ctx.strokeStyle = colour;
  chart.ctx.lineWidth = 2 * devicePixelRatio;
  chart.ctx.setLineDash(dash.map((length) => length * devicePixelRatio));
  chart.ctx.beginPath();
  chart.ctx.moveTo(x, top);
  chart.ctx.lineTo(x, top + height);
  chart.ctx.stroke();
  chart.ctx.restore();
}

/** The mark on the x axis of what is selected in all views. */
export const drawSelectedAt = (chart: UPlot, at: number, colour: string): void => drawLineAt(chart, at, colour, [4, 4]);

/** Calls `go` with the position on the x axis of each click that is not the end of a drag. */
export function onClickAt(chart: UPlot, go: (at: number) => void): void {
  let from = 0;
  chart.over.addEventListener("pointerdown", (event) => {
    from = event.clientX;
  });
  chart.over.addEventListener("click", (event) => {
    if (Math.abs(event.clientX - from) >= DRAG_PX) return;
    go(chart.posToVal(event.clientX - chart.over.getBoundingClientRect().left, "x"));
  });
}

/** A drag sets the interval, a double click resets it. uPlot's own zoom would only enlarge the coarse values. */
export function zoomInto(zoom: Signal<Span | null>): UPlot.Cursor {
  return {
    drag: { x: true, y: false, dist: DRAG_PX, setScale: false },
    points: { size: 6 },
    sync: { key: "log" },
    bind: {
      dblclick: () => () => {
        zoom.value = null;
        return null;
      },
      mouseup: (chart, _, handler) => (event) => {
        handler(event);
        const { left, width } = chart.select;
        if (width > 0) {
          zoom.value = [chart.posToVal(left, "x"), chart.posToVal(left + width, "x")];
          chart.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
        }
        return null;
      },
    },
  };
}
