/** A small drawing of each way in which poses are corrected, computed from scans of the figure's room. */

import type { ComponentChildren } from "preact";
import { useMemo } from "preact/hooks";
import { compose } from "../../grid/lattice";
import type { Point, Pose } from "../../wire/protocol";
import { oneStep, scoreLandscape } from "./matching";
import { nearestPairs, type PointScan, placed } from "./model";
import { ransac, wallsOf } from "./ransac";
import "./matching.css";
import { GEOMETRY, problemIn, scanFromPose } from "./world";

const DEGREE = Math.PI / 180;

/** The places of a short drive through the room. */
const DRIVE: readonly Pose[] = [
  [1.3, 1.3, 10 * DEGREE],
  [2.0, 1.9, 35 * DEGREE],
  [2.6, 2.6, 20 * DEGREE],
  [3.4, 2.8, -5 * DEGREE],
  [4.2, 2.4, -30 * DEGREE],
];

const dots = (scan: PointScan, has: (k: number) => boolean = () => true): string =>
  Array.from(scan.x, (x, k) =>
    scan.isPoint[k] && has(k) ? `M${x.toFixed(2)} ${(scan.y[k] ?? 0).toFixed(2)}h0` : "",
  ).join("");
const chain = (places: readonly (readonly number[])[]): string =>
  places.map(([x = 0, y = 0], k) => `${k ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`).join("");

const Dots = ({ scan, tone }: { scan: PointScan; tone: string }) => (
  <path class={`sketch-dots ${tone}`} d={dots(scan)} />
);
const Robot = ({ at, tone = "moving" }: { at: readonly number[]; tone?: string }) => (
  <circle class={`sketch-robot ${tone}`} cx={at[0]} cy={at[1]} r={0.13} />
);

/** Nearest points paired, and the poses of the iterations. */
function Icp() {
  const problem = problemIn("room");
  const { fixed, moving, start } = problem;
  const now = placed(moving, start);
  const { ours, theirs } = nearestPairs(moving, start, fixed, 1);
  const path: Pose[] = [start];
  for (let k = 0; k < 8; k++) path.push(oneStep(problem, "point_to_line", path[k] as Pose));
  return (
    <>
      <path
        class="sketch-pairs"
        d={ours
          .map((k, i) =>
            chain([
              [now.x[k] ?? 0, now.y[k] ?? 0],
              [fixed.x[theirs[i] ?? 0] ?? 0, fixed.y[theirs[i] ?? 0] ?? 0],
            ]),
          )
          .join("")}
      />
      <Dots scan={fixed} tone="fixed" />
      <Dots scan={now} tone="moving" />
      <path class="sketch-link" d={chain(path)} />
      <Robot at={path[path.length - 1] as Pose} />
    </>
  );
}

/** Links from each scan to the one before, and the newest two. */
function ScanToScan() {
  return (
    <>
      <Dots scan={scanFromPose(DRIVE[3] as Pose, 4)} tone="fixed" />
      <Dots scan={scanFromPose(DRIVE[4] as Pose, 5)} tone="moving" />
      <path class="sketch-link" d={chain(DRIVE)} />
      {DRIVE.map((pose, k) => (
        <Robot key={pose[0]} at={pose} tone={k === DRIVE.length - 1 ? "moving" : "fixed"} />
      ))}
    </>
  );
}

/** All earlier scans as one map, and links from the newest scan to each of them. */
function ScanToMap() {
  const newest = DRIVE[DRIVE.length - 1] as Pose;
  return (
    <>
      {DRIVE.slice(0, -1).map((pose, k) => (
        <Dots key={pose[0]} scan={scanFromPose(pose, k)} tone="fixed" />
      ))}
      <Dots scan={scanFromPose(newest, 5)} tone="moving" />
      {DRIVE.slice(0, -1).map((pose) => (
        <path key={pose[0]} class="sketch-link" d={chain([pose, newest])} />
      ))}
      {DRIVE.map((pose, k) => (
        <Robot key={pose[0]} at={pose} tone={k === DRIVE.length - 1 ? "moving" : "fixed"} />
      ))}
    </>
  );
}

/** Two maps of two scans each, the second one turned and moved off its place. */
function MapToMap() {
  const off: Pose = [0.75, -0.55, 9 * DEGREE];
  const away = (scan: PointScan): PointScan => placed(scan, off);
  const [from, to] = [DRIVE[4] as Pose, compose(off, DRIVE[4] as Pose)];
  return (
    <>
      {DRIVE.slice(0, 2).map((pose, k) => (
        <Dots key={pose[0]} scan={scanFromPose(pose, k)} tone="fixed" />
      ))}
      {DRIVE.slice(3).map((pose, k) => (
        <Dots key={pose[0]} scan={away(scanFromPose(pose, 3 + k))} tone="moving" />
      ))}
      <path class="sketch-link" d={chain([to, from])} />
      <path class="sketch-link fixed" d={chain(DRIVE.slice(0, 2))} />
      {DRIVE.slice(0, 2).map((pose) => (
        <Robot key={pose[0]} at={pose} tone="fixed" />
      ))}
      <Robot at={to} />
    </>
  );
}

/** The straight walls of a scan, and the corners in which two of them meet. */
function Features() {
  const scan = scanFromPose([1.9, 2.5, 20 * DEGREE], 1);
  const walls = wallsOf(scan, 0.5, 0.06, 5);
  const corners = walls.flatMap(([, end], k) => {
    const next = walls[(k + 1) % walls.length]?.[0];
    return next && Math.hypot(end[0] - next[0], end[1] - next[1]) < 0.35 ? [end] : [];
  });
  return (
    <>
      <Dots scan={scan} tone="fixed" />
      {walls.map(([a, b]) => (
        <path key={`${a}`} class="sketch-wall" d={chain([a, b])} />
      ))}
      {corners.map((at: Point) => (
        <circle key={`${at}`} class="sketch-corner" cx={at[0]} cy={at[1]} r={0.2} />
      ))}
    </>
  );
}

/** The pairs that agree with the best draw, and those that it leaves out. */
function Ransac() {
  const { fixed, moving, start } = problemIn("room");
  const pairs = nearestPairs(moving, start, fixed, 1);
  const { pose, isInlier } = ransac(moving, fixed, pairs, 0.15, 400);
  const at = placed(moving, pose);
  const agree = new Set(pairs.ours.filter((_, i) => isInlier[i]));
  const left = pairs.ours.flatMap((k, i) => {
    const j = pairs.theirs[i] ?? 0;
    return isInlier[i]
      ? []
      : [
          chain([
            [at.x[k] ?? 0, at.y[k] ?? 0],
            [fixed.x[j] ?? 0, fixed.y[j] ?? 0],
          ]),
        ];
  });
  return (
    <>
      <path class="sketch-pairs" d={left.join("")} />
      <Dots scan={fixed} tone="fixed" />
      <path class="sketch-dots moving" d={dots(at, (k) => agree.has(k))} />
      <path class="sketch-dots outlier" d={dots(at, (k) => !agree.has(k))} />
    </>
  );
}

const BLOCK = 4;

/** The bounds of a coarse raster, and the cell of the fine one with the best score. */
function Correlative() {
  const problem = problemIn("room");
  const scores = scoreLandscape(problem, problem.truth[2]);
  const { rows, cols, resolution } = GEOMETRY;
  const side = BLOCK * resolution;
  const blocks = Array.from({ length: (rows / BLOCK) * (cols / BLOCK) }, (_, n) => {
    const [row, col] = [Math.floor(n / (cols / BLOCK)), n % (cols / BLOCK)];
    let most = 0;
    for (let r = 0; r < BLOCK; r++)
      for (let c = 0; c < BLOCK; c++) most = Math.max(most, scores[(BLOCK * row + r) * cols + BLOCK * col + c] ?? 0);
    return { x: col * side, y: row * side, most };
  });
  return (
    <>
      {blocks.map(({ x, y, most }) => (
        <rect
          key={`${x} ${y}`}
          class="sketch-block"
          x={x}
          y={y}
          width={side}
          height={side}
          style={{ opacity: most ** 1.5 }}
        />
      ))}
      <Dots scan={problem.fixed} tone="fixed" />
      <Dots scan={placed(problem.moving, problem.truth)} tone="moving" />
      <Robot at={problem.truth} />
    </>
  );
}

const SKETCHES = {
  icp: Icp,
  "scan-to-scan": ScanToScan,
  "scan-to-map": ScanToMap,
  "map-to-map": MapToMap,
  features: Features,
  ransac: Ransac,
  correlative: Correlative,
} as const;

export type SketchName = keyof typeof SKETCHES;

/** One of the sketches, in metres of the room, y upwards. */
export function Sketch({ name }: { readonly name: SketchName }) {
  const drawing = useMemo<ComponentChildren>(() => SKETCHES[name](), [name]);
  return (
    <svg class="sketch" viewBox="0.2 0.2 6 4.4" aria-hidden="true">
      <g transform="matrix(1 0 0 -1 0 4.8)">{drawing}</g>
    </svg>
  );
}
