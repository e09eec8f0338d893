import type { ComponentType } from "preact";
import { Beams, Walls } from "../common/Scene";
import { castRay } from "../common/world";
import { sonarScan } from "../sonar/world";
import { BeamCells, ReadingCells } from "./BeamCells";
import { CellCounts, CellLines, CellValues } from "./CellMarks";
import { laserHeight, wallNoise, wallWindow } from "./controls";
import { CORNERS, sightings } from "./corners";
import { Frame } from "./Frame";
import { LOW_TABLE, LOW_TABLE_HEIGHT, POLISHED, TABLE, WALLS, walker } from "./floor";
import { LoopMarks } from "./LoopMarks";
import type { Mark, MarkProps } from "./scene";
import { believed, SONAR, SONAR_REACH, scanAt, wallsAt } from "./sensing";
import { STRETCH } from "./wall";

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

/** The drive so far; where the map is made with other poses, those too. */
function Odometry({ transform, scene, shown }: MarkProps) {
  const poses = scene.poses.slice(0, shown.count);
  const line = (points: readonly (readonly number[])[]): string =>
    points.map(([x = 0, y = 0], i) => `${i === 0 ? "M" : "L"}${transform.x(x)} ${transform.y(y)}`).join("");
  const off = poses.map((pose, i) => believed(pose, i, scene.conditions, scene.poses));
  return (
    <>
      <path class="world-stage-path" d={line(poses)} />
      <path class="world-stage-path odometry" d={line(off)} />
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

/** The cones of the newest sonar scan, each with its arc. */
function Cones({ transform, scene, shown }: MarkProps) {
  const at = shown.count - 1;
  const pose = scene.poses[at];
  if (!pose) return null;
  const scan = sonarScan(pose, SONAR.opening, wallsAt(at, scene.conditions), SONAR_REACH);
  const [x, y] = [transform.x(pose[0]), transform.y(pose[1])];
  const wedges = Array.from(scan.ranges, (range, k) => {
    if (!Number.isFinite(range)) return "";
    const r = range * transform.metre;
    const point = (off: number): string => {
      const angle = pose[2] + (scan.bearings[k] ?? 0) + off;
      return `${x + r * Math.cos(angle)} ${y - r * Math.sin(angle)}`;
    };
    return `M${x} ${y}L${point(-SONAR.opening / 2)}A${r} ${r} 0 0 0 ${point(SONAR.opening / 2)}Z`;
  });
  return <path class="world-stage-cones" d={wedges.join("")} />;
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
  const [sigma, r] = [Math.max(0.004, wallNoise.value), wallWindow.value];
  const x0 = transform.x(STRETCH.to + 0.02);
  const tall = 0.3 * transform.metre;
  const points = Array.from({ length: 61 }, (_, i) => {
    const off = ((i - 30) / 30) * 4 * sigma;
    return `${i === 0 ? "M" : "L"}${x0 + tall * Math.exp(-((off / sigma) ** 2) / 2)} ${transform.y(wall + off)}`;
  });
  const [low, high] = [transform.y(wall - r / 2), transform.y(wall + r / 2)];
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
        window {r.toFixed(2)} m
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
