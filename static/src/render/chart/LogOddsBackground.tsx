/** The background of a chart of log-odds: the zones of the three states, the clamp's limits, the axis. */

import { logOdds } from "../../grid/cellValues";
import { signed } from "../../ui/numbers";
import { FREE_THRESHOLD, OCCUPIED_THRESHOLD } from "../../wire/constants";
import { type Scale, toPixel } from "./scale";
import "./chart.css";

export const FREE = logOdds(FREE_THRESHOLD);
export const OCCUPIED = logOdds(OCCUPIED_THRESHOLD);
const AXIS_PX = 54;
/** Height that the label of a tick takes. */
const LABEL_PX = 17;
const EDGE_PX = 8;
/** Width of the names of the zones: lines end before them. */
const NAMES_PX = 66;

/** The vertical axis; it contains the limits and every value. */
export function evidenceScale(height: number, limits: readonly number[], values: readonly number[]): Scale {
  const ends = limits.length > 0 ? limits.map((limit) => limit + 0.5 * Math.sign(limit)) : [];
  return {
    low: Math.min(-2.6, ...ends, ...values),
    high: Math.max(4, ...ends, ...values),
    from: height - EDGE_PX,
    to: EDGE_PX,
  };
}

/** The horizontal axis of `low` … `high` readings, left of the names of the zones. */
export const readingScale = (width: number, low: number, high: number): Scale => ({
  low,
  high,
  from: AXIS_PX,
  to: width - EDGE_PX - NAMES_PX,
});

/** Height of the title of the horizontal axis, below the chart. */
export const TITLE_PX = 18;

interface AxisTitleProps {
  readonly width: number;
  readonly height: number;
  readonly text: string;
}

/** The title of the horizontal axis, below a chart of this height. */
export function ReadingTitle({ width, height, text }: AxisTitleProps) {
  return (
    <text class="tick" x={(AXIS_PX + width - EDGE_PX) / 2} y={height + TITLE_PX - 8} text-anchor="middle">
      {text}
    </text>
  );
}

const zonesOf = ({ low, high }: Scale) =>
  [
    ["zone-hit", "occupied", high, OCCUPIED],
    ["zone-prior", "unknown", OCCUPIED, FREE],
    ["zone-miss", "free", FREE, low],
  ] as const;

interface ZonesProps {
  readonly width: number;
  readonly evidence: Scale;
}

/** The names of the zones, right of the lines. */
export function ZoneNames({ width, evidence }: ZonesProps) {
  const y = (value: number): number => toPixel(value, evidence);
  return (
    <>
      {zonesOf(evidence).map(
        ([name, state, top, bottom]) =>
          y(bottom) - y(top) > 15 && (
            <text
              key={name}
              class={`zone-name in-${name}`}
              x={width - EDGE_PX - 6}
              // Most lines of free cells are at the lower clamp: the label is placed above them.
              y={name === "zone-miss" ? y(top) + 13 : y(bottom) - 5}
              text-anchor="end"
            >
              {state}
            </text>
          ),
      )}
    </>
  );
}

interface LogOddsBackgroundProps extends ZonesProps {
  readonly limits: readonly number[];
}

export function LogOddsBackground({ width, evidence, limits }: LogOddsBackgroundProps) {
  const y = (value: number): number => toPixel(value, evidence);
  const { low, high } = evidence;
  const right = width - EDGE_PX;
  const zones = zonesOf(evidence);
  // At most one tick in seven, and no two labels over each other.
  const every = Math.max(high - low > 14 ? Math.ceil((high - low) / 7) : 1, Math.ceil(LABEL_PX / (y(0) - y(1))));
  const ticks: number[] = [];
  for (let tick = Math.ceil(low / every); tick * every <= high - 0.5; tick++) ticks.push(tick * every);
  return (
    <>
      {zones.map(([name, , top, bottom]) => (
        <rect key={name} class={name} x={AXIS_PX} y={y(top)} width={right - AXIS_PX} height={y(bottom) - y(top)} />
      ))}
      {limits.map((limit) => (
        <line key={limit} class="clamp-line" x1={AXIS_PX} x2={right} y1={y(limit)} y2={y(limit)} />
      ))}
      {ticks.map((tick) => (
        <text key={tick} class="tick" x={AXIS_PX - 6} y={y(tick) + 4} text-anchor="end">
          {tick === 0 ? "0" : signed(tick, 0)}
        </text>
      ))}
      <text
        class="tick"
        transform={`translate(14 ${(evidence.from + evidence.to) / 2}) rotate(-90)`}
        text-anchor="middle"
      >
        log-odds ℓ
      </text>
    </>
  );
}
