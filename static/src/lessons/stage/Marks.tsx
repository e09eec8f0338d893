import type { ComponentType } from "preact";
import { probability } from "../../grid/cellValues";
import { cellAt } from "../../grid/lattice";
import { indexOf } from "../../grid/occupancyGrid";
import { halfWindow } from "../../grid/sensorModel";
import { evidenceOfBeam } from "../../grid/textbook";
import { signed, written } from "../../ui/numbers";
import type { Pose } from "../../wire/protocol";
import { DragHandle } from "../common/DragHandle";
import { Beams, Walls } from "../common/Scene";
import type { StageTransform } from "../common/Stage";
import { castRay } from "../common/world";
import {
  cellSide,
  laserHeight,
  originAt,
  pipelineBeam,
  pipelineStep,
  visited,
  wallNoise,
  wallWindow,
} from "./controls";
import { CORNERS, FLOOR, LOW_TABLE, LOW_TABLE_HEIGHT, POLISHED, sightings, TABLE, WALLS, walker } from "./floor";
import { FIELD, LOOP_GEOMETRY, visitOf } from "./loop";
import { readingOf } from "./reading";
import type { Mark, MarkProps } from "./scene";
import { believed, conesAt, scanAt } from "./sensing";
import { STRETCH } from "./wall";

/** Cells smaller than this have no borders; smaller than that no number in them, CSS pixels. */
const LEAST_LINES = 5;
const LEAST_NUMBER = 20;
const LEAST_VALUES = 46;
/** Log-odds above which a cell is painted so strongly that its text has the colour of the page. */
const DARK = 2;
/** Half the width of the label of a reading, CSS pixels. */
const LABEL_HALF = 112;

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

function CellLines({ transform, shown }: MarkProps) {
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
function CellValues(props: MarkProps) {
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
function CellCounts(props: MarkProps) {
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

/** The loop of table 9.1: the perceptual field outlined, and the cell that is visited now. */
function LoopMarks({ transform }: MarkProps) {
  const { cols, resolution } = LOOP_GEOMETRY;
  const inside = new Set(FIELD);
  // A border wherever a cell of the field has a neighbour outside it.
  const borders = FIELD.flatMap((i) => {
    const [row, col] = [Math.floor(i / cols), i % cols];
    const [x, y] = [transform.x(col * resolution), transform.y((row + 1) * resolution)];
    const side = transform.cell;
    return [
      inside.has(i - 1) && col > 0 ? "" : `M${x} ${y}v${side}`,
      inside.has(i + 1) ? "" : `M${x + side} ${y}v${side}`,
      inside.has(i + cols) ? "" : `M${x} ${y}h${side}`,
      inside.has(i - cols) ? "" : `M${x} ${y + side}h${side}`,
    ];
  });
  const { cell } = visitOf(Math.max(0, visited.value - 1));
  return (
    <>
      <path class="world-stage-field" d={borders.join("")} />
      <rect
        class="world-stage-selected"
        x={transform.x(cell.col * resolution)}
        y={transform.y((cell.row + 1) * resolution)}
        width={transform.cell}
        height={transform.cell}
      />
    </>
  );
}

const limited = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

function Frame({ transform, scene, shown }: MarkProps) {
  const [ox, oy] = originAt.value;
  const side = cellSide.value;
  const reading = readingOf(scene, shown, pipelineBeam.value);
  const columns = Math.ceil((FLOOR.width - ox) / side);
  const rows = Math.ceil((FLOOR.height - oy) / side);
  const [left, top] = [transform.x(ox), transform.y(oy + rows * side)];
  const lines = [
    ...Array.from({ length: columns + 1 }, (_, i) => `M${transform.x(ox + i * side)} ${transform.y(oy)}V${top}`),
    ...Array.from(
      { length: rows + 1 },
      (_, i) => `M${left} ${transform.y(oy + i * side)}H${transform.x(ox + columns * side)}`,
    ),
  ];
  const lattice = { origin: [ox, oy, 0] as const, resolution: side };
  const cell = reading && cellAt(lattice, reading.end[0], reading.end[1]);
  const far: readonly [number, number] = reading ? [transform.x(reading.end[0]), transform.y(reading.end[1])] : [0, 0];
  return (
    <>
      <path class="cell-lines" d={lines.join("")} />
      {reading && cell && (
        <>
          <rect
            class="world-stage-cell hit"
            x={transform.x(ox + cell.col * side)}
            y={transform.y(oy + (cell.row + 1) * side)}
            width={side * transform.metre}
            height={side * transform.metre}
          />
          <path class="world-stage-count" d={`M${transform.x(ox)} ${transform.y(oy)}H${far[0]}V${far[1]}`} />
          <path
            class="world-stage-beam"
            d={`M${transform.x(reading.pose[0])} ${transform.y(reading.pose[1])}L${far[0]} ${far[1]}`}
          />
          <circle class="world-stage-end" cx={far[0]} cy={far[1]} r={6} />
          <text
            class="world-stage-label beam"
            x={Math.max(LABEL_HALF, Math.min(far[0], transform.width - LABEL_HALF))}
            y={far[1] + 28}
            text-anchor="middle"
          >
            ({written(reading.end[0], 2)}, {written(reading.end[1], 2)}) m → column {cell.col}, row {cell.row}
          </text>
        </>
      )}
      <DragHandle
        transform={transform}
        at={originAt.value}
        label="Origin of the grid"
        sentence="Moves the lower left corner of the grid; all columns and rows are counted from it."
        text={`${written(ox, 2)} m, ${written(oy, 2)} m`}
        tone="neutral"
        step={0.1}
        onMove={([x, y]) => {
          originAt.value = [limited(x, 0, 3), limited(y, 0, 2)];
        }}
      >
        <path class="world-stage-origin" d="M-14 0H22M16 -5L22 0L16 5M0 14V-22M-5 -16L0 -22L5 -16" />
      </DragHandle>
    </>
  );
}

/** How far a reading has come: 1 its end point, 2 that cell, 3 the cells of its beam, 4 their evidence. */
const ALL = 4;

interface BeamProps extends MarkProps {
  readonly step: number;
}

const BeamCells = (props: MarkProps) => <Beam {...props} step={ALL} />;
const ReadingCells = (props: MarkProps) => <Beam {...props} step={pipelineStep.value} />;

/** The chosen beam of the newest scan. */
function Beam({ transform, scene, shown, step }: BeamProps) {
  const reading = readingOf(scene, shown, pipelineBeam.value);
  if (!reading) return null;
  const { pose, end, range, cells } = reading;
  const { resolution } = shown.map.geometry;
  const half = scene.config.window / 2;
  const angle = pose[2] + reading.bearing;
  const at = (z: number): string =>
    `${transform.x(pose[0] + z * Math.cos(angle))} ${transform.y(pose[1] + z * Math.sin(angle))}`;
  return (
    <>
      {step >= 3 &&
        cells.map(({ cell, evidence }) => (
          <rect
            key={`${cell.row} ${cell.col}`}
            class={`world-stage-cell ${step < ALL ? "line" : evidence > 0 ? "hit" : "miss"}`}
            x={transform.x(cell.col * resolution)}
            y={transform.y((cell.row + 1) * resolution)}
            width={transform.cell}
            height={transform.cell}
          />
        ))}
      <path class="world-stage-beam" d={`M${at(0)}L${at(range)}`} />
      {half > 0 && <path class="world-stage-beam-window" d={`M${at(range - half)}L${at(range + half)}`} />}
      {step >= 1 && <circle class="world-stage-end" cx={transform.x(end[0])} cy={transform.y(end[1])} r={6} />}
      <text class="world-stage-label beam" x={transform.x(end[0]) + 12} y={transform.y(end[1]) - 16}>
        z = {written(range, 2)} m
      </text>
      {step === 2 && (
        <rect
          class="world-stage-selected"
          x={transform.x(reading.cell.col * resolution)}
          y={transform.y((reading.cell.row + 1) * resolution)}
          width={transform.cell}
          height={transform.cell}
        />
      )}
    </>
  );
}

/** The true walls, and who walks between them. */
export function World({ transform, scene, shown }: MarkProps) {
  const { conditions } = scene;
  const gone = shown.count > conditions.tableUntil;
  // Values are written where the walls run.
  if (scene.marks.includes("values")) return null;
  return (
    <>
      <Walls transform={transform} walls={WALLS} tone="wall faint" />
      <Walls transform={transform} walls={[POLISHED]} tone={conditions.polished ? "wall polished" : "wall faint"} />
      <Walls transform={transform} walls={TABLE} tone={gone ? "wall gone" : "wall faint"} />
      {conditions.people && <Walls transform={transform} walls={walker(shown.count - 1)} tone="wall walker" />}
      {scene.marks.includes("low-table") && (
        <>
          <Walls
            transform={transform}
            walls={LOW_TABLE}
            tone={laserHeight.value > LOW_TABLE_HEIGHT ? "wall glass" : "wall faint"}
          />
          <text class="world-stage-label" x={transform.x(1.835)} y={transform.y(5.7)} text-anchor="middle">
            low table
          </text>
        </>
      )}
    </>
  );
}

/** The poses with which the map is made, and dashed the true ones, as in the figure of the section. */
function Odometry({ transform, scene, shown }: MarkProps) {
  const poses = scene.poses.slice(0, shown.count);
  const line = (points: readonly (readonly number[])[]): string =>
    points.map(([x = 0, y = 0], i) => `${i === 0 ? "M" : "L"}${transform.x(x)} ${transform.y(y)}`).join("");
  const off = poses.map((pose, i) => believed(pose, i, scene.conditions, scene.poses));
  return (
    <>
      <path class="world-stage-path odometry" d={line(off)} />
      <path class="world-stage-path" d={line(poses)} />
    </>
  );
}

function NewestScan({ transform, scene, shown }: MarkProps) {
  const at = shown.count - 1;
  const pose = scene.poses[at];
  if (!pose) return null;
  const from = believed(pose, at, scene.conditions, scene.poses);
  return <Beams transform={transform} pose={from} scan={scanAt(pose, at, scene.conditions)} />;
}

/** The arc at a distance from the sensor across a cone, right to left. */
function arcOf(transform: StageTransform, pose: Pose, bearing: number, opening: number, range: number): string {
  const r = range * transform.metre;
  const point = (off: number): string => {
    const angle = pose[2] + bearing + off;
    return `${transform.x(pose[0]) + r * Math.cos(angle)} ${transform.y(pose[1]) - r * Math.sin(angle)}`;
  };
  return `${point(-opening / 2)}A${r} ${r} 0 0 0 ${point(opening / 2)}`;
}

/** The cones of the newest sonar scan, each with its arc. */
function Cones({ transform, scene: { poses, conditions, cone }, shown }: MarkProps) {
  const at = shown.count - 1;
  const pose = poses[at];
  if (!pose || !cone) return null;
  const scan = conesAt(pose, at, conditions, cone);
  const from = `M${transform.x(pose[0])} ${transform.y(pose[1])}L`;
  const wedges = Array.from(scan.ranges, (range, k) =>
    Number.isFinite(range) ? `${from}${arcOf(transform, pose, scan.bearings[k] ?? 0, cone.opening, range)}Z` : "",
  );
  return <path class="world-stage-cones" d={wedges.join("")} />;
}

/** The cone next to the chosen beam, with the window of its arc. */
function Cone({ transform, scene, shown }: MarkProps) {
  const reading = readingOf(scene, shown, pipelineBeam.value);
  const { cone } = scene;
  if (!reading || !cone) return null;
  const { pose, bearing, range, end } = reading;
  const half = halfWindow(range, { ...cone, resolution: scene.resolution });
  const arc = (r: number): string => arcOf(transform, pose, bearing, cone.opening, Math.max(0, r));
  return (
    <>
      <path class="world-stage-cones" d={`M${transform.x(pose[0])} ${transform.y(pose[1])}L${arc(range + half)}Z`} />
      <path class="world-stage-arc" d={`M${arc(range - half)}M${arc(range + half)}`} />
      <circle class="world-stage-end" cx={transform.x(end[0])} cy={transform.y(end[1])} r={6} />
      <text class="world-stage-label beam" x={transform.x(end[0]) + 12} y={transform.y(end[1]) - 16}>
        z = {written(range, 2)} m
      </text>
    </>
  );
}

/** Corners that were seen, each with a circle whose radius is σ/√n after n sightings. */
function Corners({ transform, scene, shown }: MarkProps) {
  const counts = sightings(scene.poses.slice(0, shown.count));
  return (
    <>
      {CORNERS.map(([x, y], i) => {
        const n = counts[i] ?? 0;
        if (n === 0) return null;
        const r = Math.max(9, (0.35 / Math.sqrt(n)) * transform.metre);
        return (
          <g key={`${x} ${y}`} class="world-stage-corner" transform={`translate(${transform.x(x)} ${transform.y(y)})`}>
            <circle r={r} />
            <path d="M-9 0H9M0 -9V9" />
          </g>
        );
      })}
    </>
  );
}

/** The distribution of a range at the wall, as a Gaussian across it, and the window. */
function Noise({ transform, scene, shown }: MarkProps) {
  const at = shown.count - 1;
  const pose = scene.poses[Math.min(at, 5)];
  if (!pose) return null;
  const distance = castRay(WALLS, pose[0], pose[1], Math.PI / 2);
  const wall = pose[1] + distance;
  const [sigma, w] = [Math.max(0.004, wallNoise.value), wallWindow.value];
  const x0 = transform.x(STRETCH.to + 0.02);
  const tall = 0.3 * transform.metre;
  const points = Array.from({ length: 61 }, (_, i) => {
    const off = ((i - 30) / 30) * 4 * sigma;
    return `${i === 0 ? "M" : "L"}${x0 + tall * Math.exp(-((off / sigma) ** 2) / 2)} ${transform.y(wall + off)}`;
  });
  const [low, high] = [transform.y(wall - w / 2), transform.y(wall + w / 2)];
  return (
    <>
      <rect
        class="world-stage-window"
        x={transform.x(STRETCH.from)}
        y={high}
        width={transform.x(STRETCH.to) - transform.x(STRETCH.from)}
        height={Math.max(1, low - high)}
      />
      <path class="world-stage-gauss" d={`${points.join("")}L${x0} ${transform.y(wall + 4 * sigma)}`} />
      <text
        class="world-stage-label"
        x={Math.min(x0 + tall, transform.width - 8)}
        y={transform.y(wall - 4 * sigma) + 20}
        text-anchor="end"
      >
        p(z), σ = {sigma.toFixed(2)} m
      </text>
      <text class="world-stage-label" x={transform.x(STRETCH.from)} y={transform.y(wall + 0.42)}>
        window {w.toFixed(2)} m
      </text>
    </>
  );
}

const DRAWN: Readonly<Record<Mark, ComponentType<MarkProps>>> = {
  lines: CellLines,
  beams: NewestScan,
  beam: BeamCells,
  reading: ReadingCells,
  corners: Corners,
  field: LoopMarks,
  counts: CellCounts,
  frame: Frame,
  noise: Noise,
  odometry: Odometry,
  cones: Cones,
  cone: Cone,
  "low-table": () => null,
  values: CellValues,
};

/** What a scene draws over the map. */
export function Marks(props: MarkProps) {
  return (
    <>
      {props.scene.marks.map((mark) => {
        const Drawn = DRAWN[mark];
        return <Drawn key={mark} {...props} />;
      })}
    </>
  );
}
