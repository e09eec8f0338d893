import { computed, type Signal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import { cellAt } from "../../grid/lattice";
import { INITIAL_CONFIG, indexOf } from "../../grid/occupancyGrid";
import { linePath } from "../../render/chart/scale";
import { bound } from "../../ui/bound";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import type { Point } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Plot } from "../common/Plot";
import { Scene } from "../common/Scene";
import { beamsPerCell, distanceOf, expectedBeams, GEOMETRY, mapWith, SENSOR, WALLS } from "./model";
import "./counting.css";

const KINDS = [
  { update: "per_beam", name: "per beam" },
  { update: "per_scan", name: "per scan" },
] as const;

const inside = ([x, y]: Point): Point => [Math.min(3.75, Math.max(0.05, x)), Math.min(2.55, Math.max(0.05, y))];

interface CountingProps {
  readonly beams: Signal<number>;
  readonly scans: Signal<number>;
}

/** The map of the same scans, updated per beam and per scan; a cross selects one cell to compare. */
export function Counting({ beams, scans }: CountingProps) {
  const probe = useSignal<Point>([1.46, 1.35]);
  const counts = useMemo(() => computed(() => beamsPerCell(beams.value)), [beams]);
  const maps = useMemo(
    () => KINDS.map(({ update }) => computed(() => mapWith(update, beams.value, scans.value))),
    [beams, scans],
  );
  const cell = cellAt(GEOMETRY, probe.value[0], probe.value[1]);
  const index = indexOf(GEOMETRY, cell);
  const touched = counts.value[index] ?? 0;
  return (
    <figure class="counting stack" aria-label="The map of the same scans, updated per beam and per scan">
      <div class="side-by-side">
        {KINDS.map(({ update, name }, i) => {
          const map = maps[i];
          if (!map) return null;
          const l = map.value.logOdds[index] ?? 0;
          const seen = map.value.observed[index] === 1;
          return (
            <div key={update}>
              <h3>{name}</h3>
              <Scene geometry={GEOMETRY} label={`The map, updated ${name}`} grid={map} walls={WALLS}>
                {(transform) => (
                  <>
                    <g transform={`translate(${transform.x(SENSOR[0])} ${transform.y(SENSOR[1])})`}>
                      <RobotShape yaw={0} size={7} />
                    </g>
                    <rect
                      class="probe-cell"
                      x={cell.col * transform.cell}
                      y={transform.height - (cell.row + 1) * transform.cell}
                      width={transform.cell}
                      height={transform.cell}
                    />
                    <DragHandle
                      transform={transform}
                      at={probe.value}
                      label={`Selected cell, map ${name}`}
                      sentence="Selects the cell whose values are shown under both maps."
                      text={`${written(distanceOf(cell), 2)} metres from the sensor: ${seen ? `log-odds ${written(l, 2)}` : "not observed"}`}
                      tone="neutral"
                      step={GEOMETRY.resolution}
                      onMove={(point) => {
                        probe.value = inside(point);
                      }}
                    >
                      <path class="probe" d="M-13 0H-5M5 0H13M0 -13V-5M0 5V13" />
                    </DragHandle>
                  </>
                )}
              </Scene>
              <p class="number" aria-live="polite">
                {seen ? (
                  <>
                    Under the cross: ℓ&nbsp;= <b>{written(l, 2)}</b>, <i>p</i>&nbsp;=&nbsp;{written(probability(l), 2)}
                    {(l <= INITIAL_CONFIG.log_odds_min || l >= INITIAL_CONFIG.log_odds_max) && ", at the clamp"}
                  </>
                ) : (
                  "Under the cross: not observed"
                )}
              </p>
            </div>
          );
        })}
      </div>
      <Plot height={HEIGHT} label="Beams of one scan in a cell, over the cell’s distance">
        {(width) => <Scatter counts={counts.value} beams={beams.value} chosen={index} width={width} />}
      </Plot>
      <div class="figure-controls no-print">
        <Slider
          label="Beams per scan"
          sentence="Number of beams in one scan, evenly spaced over 360°."
          {...bound(beams)}
          initial={180}
          low={36}
          high={720}
          step={12}
        />
      </div>
      <figcaption class="number">
        One scan updates the cell under the cross, {written(distanceOf(cell), 2)} m from the sensor,{" "}
        <b>
          {touched} {touched === 1 ? "time" : "times"}
        </b>
        .
      </figcaption>
    </figure>
  );
}

const HEIGHT = 150;
const LEFT = 40;

interface ScatterProps {
  readonly counts: Uint16Array;
  readonly beams: number;
  readonly chosen: number;
  readonly width: number;
}

/** How many beams of one scan update each cell, over its distance. */
function Scatter({ counts, beams, chosen, width }: ScatterProps) {
  const far = 2.7;
  const most = Math.max(8, expectedBeams(0.15, beams));
  const x = (s: number): number => LEFT + ((width - LEFT - 10) * s) / far;
  const y = (n: number): number => HEIGHT - 24 - ((HEIGHT - 40) * Math.min(n, most)) / most;
  const distances = Array.from({ length: 90 }, (_, i) => 0.15 + ((far - 0.15) * i) / 89);
  const curve = linePath(distances.map((s) => [x(s), y(expectedBeams(s, beams))]));
  const dots = [...counts.keys()].filter((i) => (counts[i] ?? 0) > 0 && i !== chosen);
  const isOver = (i: number): boolean => (counts[i] ?? 0) > most;
  const point = (i: number): readonly [number, number] => [
    x(distanceOf({ row: Math.floor(i / GEOMETRY.cols), col: i % GEOMETRY.cols })),
    y(counts[i] ?? 0),
  ];
  const path = dots.map((i) => {
    const [px, py] = point(i);
    // An arrow where the axis does not reach.
    return isOver(i) ? `M${px - 4} ${py + 3}l4 -6l4 6` : `M${px.toFixed(1)} ${py.toFixed(1)}h0`;
  });
  const over = [...counts.keys()].filter(isOver).length;
  const [cx, cy] = point(chosen);
  return (
    <>
      <line class="zero" x1={LEFT} x2={width - 10} y1={y(0)} y2={y(0)} />
      <path class="counting-dots" d={path.join("")} />
      <path class="counting-curve" d={curve} />
      <circle class="counting-chosen" cx={cx} cy={cy} r={7} />
      <text x={LEFT - 6} y={y(0) + 4} text-anchor="end">
        0
      </text>
      <text x={LEFT - 6} y={y(most) + 6} text-anchor="end">
        {Math.round(most)}
      </text>
      <text x={width - 10} y={HEIGHT - 6} text-anchor="end">
        distance of the cell: {far} m
      </text>
      <text x={width - 10} y={14} text-anchor="end">
        beams in a cell
        {over > 0 && ` (${over} ${over === 1 ? "cell has" : "cells have"} more than ${Math.round(most)})`}
      </text>
    </>
  );
}
