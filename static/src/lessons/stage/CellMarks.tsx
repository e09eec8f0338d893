/** What is drawn into the cells that are in view: their borders, numbers, values. */

import { probability } from "../../grid/cellValues";
import { indexOf } from "../../grid/occupancyGrid";
import { evidenceOfBeam } from "../../grid/textbook";
import { signed, written } from "../../ui/numbers";
import type { StageTransform } from "../common/Stage";
import type { MarkProps } from "./scene";
import { scanAt } from "./sensing";

/** Cells smaller than this have no borders; smaller than that no number in them, CSS pixels. */
const LEAST_LINES = 5;
const LEAST_NUMBER = 20;
const LEAST_VALUES = 46;
/** Log-odds above which a cell is painted so strongly that its text has the colour of the page. */
const DARK = 2;

/** First and last row and column of the cells in view. */
function inView(transform: StageTransform, { map }: MarkProps["shown"]) {
  const { rows, cols, resolution } = map.geometry;
  const [x0, y0] = transform.world(0, transform.height);
  const [x1, y1] = transform.world(transform.width, 0);
  const limited = (value: number, most: number): number => Math.min(most, Math.max(0, Math.floor(value / resolution)));
  return {
    col0: limited(x0, cols - 1),
    col1: limited(x1, cols - 1),
    row0: limited(y0, rows - 1),
    row1: limited(y1, rows - 1),
  };
}

export function CellLines({ transform, shown }: MarkProps) {
  const { resolution } = shown.map.geometry;
  if (transform.cell < LEAST_LINES) return null;
  const { col0, col1, row0, row1 } = inView(transform, shown);
  const [left, right] = [transform.x(col0 * resolution), transform.x((col1 + 1) * resolution)];
  const [low, high] = [transform.y(row0 * resolution), transform.y((row1 + 1) * resolution)];
  const path = [
    ...Array.from({ length: col1 - col0 + 2 }, (_, i) => `M${transform.x((col0 + i) * resolution)} ${low}V${high}`),
    ...Array.from({ length: row1 - row0 + 2 }, (_, i) => `M${left} ${transform.y((row0 + i) * resolution)}H${right}`),
  ];
  return <path class="cell-lines" d={path.join("")} />;
}

interface Entry {
  readonly index: number;
  readonly x: number;
  readonly y: number;
}

/** The middle of each cell in view. */
function entries(props: MarkProps): readonly Entry[] {
  const { cols, resolution } = props.shown.map.geometry;
  const { col0, col1, row0, row1 } = inView(props.transform, props.shown);
  const visible: Entry[] = [];
  for (let row = row0; row <= row1; row++)
    for (let col = col0; col <= col1; col++)
      visible.push({
        index: row * cols + col,
        x: props.transform.x((col + 0.5) * resolution),
        y: props.transform.y((row + 0.5) * resolution),
      });
  return visible;
}

/** p of each cell, and below it ℓ. */
export function CellValues(props: MarkProps) {
  if (props.transform.cell < LEAST_VALUES) return null;
  const { map } = props.shown;
  const size = Math.min(26, props.transform.cell / 4.5);
  return (
    <g class="world-stage-values" style={{ "font-size": `${size}px` }}>
      {entries(props).map(({ index, x, y }) => {
        const l = map.logOdds[index] ?? 0;
        const seen = map.observed[index] === 1;
        return (
          <text key={index} class={seen && l > DARK ? "on-occupied" : ""} x={x} y={y} text-anchor="middle">
            <tspan x={x}>{seen ? `p ${written(probability(l), 2)}` : "prior"}</tspan>
            <tspan x={x} dy="1.25em">
              {seen ? `ℓ ${signed(l)}` : "p 0.50"}
            </tspan>
          </text>
        );
      })}
    </g>
  );
}

/** How many updates the newest scan gives each cell. */
export function CellCounts(props: MarkProps) {
  const { shown, scene, transform } = props;
  const at = shown.count - 1;
  const pose = scene.poses[at];
  if (!pose || transform.cell < LEAST_NUMBER) return null;
  const { geometry } = shown.map;
  const scan = scanAt(pose, at, scene.conditions);
  const counts = new Map<number, number>();
  scan.ranges.forEach((_, beam) => {
    for (const { cell } of evidenceOfBeam(geometry, scan, beam, pose, scene.config)) {
      const index = indexOf(geometry, cell);
      counts.set(index, scene.config.update === "per_scan" ? 1 : (counts.get(index) ?? 0) + 1);
    }
  });
  const size = Math.min(20, transform.cell / 2.4);
  return (
    <g class="world-stage-values" style={{ "font-size": `${size}px` }}>
      {entries(props).map(({ index, x, y }) =>
        counts.has(index) ? (
          <text
            key={index}
            class={(shown.map.logOdds[index] ?? 0) > DARK ? "on-occupied" : ""}
            x={x}
            y={y + size / 3}
            text-anchor="middle"
          >
            {counts.get(index)}
          </text>
        ) : null,
      )}
    </g>
  );
}
