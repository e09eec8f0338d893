/** A drive round a block, once and a half: the poses that noisy odometry gives, and those that matching corrects. */

import { compose } from "../../grid/lattice";
import {
  emptyGrid,
  type GridGeometry,
  INITIAL_CONFIG,
  type LaserScan,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import { between } from "../../grid/poses";
import { normal, seeded } from "../../grid/random";
import { occupancyGridMapping } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import { poseRound, rmsDistance } from "../common/drive";
import { allRound, box, chained, scanFrom, type Wall } from "../common/world";
import { iterate, type PointScan, placed, pointsOf, type SurfaceScan, withNormals } from "../matching/model";

export const GEOMETRY: GridGeometry = { resolution: 0.2, rows: 46, cols: 66, origin: [-1.6, -1.6, 0] };

export const WALLS: readonly Wall[] = [
  ...box(0, 0, 10, 6),
  ...box(2.2, 2, 7.8, 4),
  ...box(8.9, 5.2, 10, 6),
  ...box(0, 5, 0.8, 6),
  ...box(4.4, 0, 5.2, 0.5),
  ...box(3.2, 5.6, 3.8, 6),
  ...box(7.8, 2.7, 8.2, 3.2),
];

const CORNERS: readonly Point[] = [
  [1.1, 1.1],
  [8.9, 1.1],
  [8.9, 4.9],
  [1.1, 4.9],
];
const SPACING = 0.58;
const SCANS = 60;

export const TRUTH: readonly Pose[] = Array.from({ length: SCANS }, (_, k) => poseRound(CORNERS, SPACING * k));
const MOTIONS: readonly Pose[] = TRUTH.slice(1).map((pose, k) => between(TRUTH[k] as Pose, pose));

const noise = { sigma: 0.01, random: seeded(5) };
const LASER_SCANS: readonly LaserScan[] = TRUTH.map((pose) => scanFrom(WALLS, pose, { ...allRound(72, 5), noise }));

/** Every second beam, for the maps. */
const THINNED: readonly LaserScan[] = LASER_SCANS.map((scan) => ({
  ...scan,
  ranges: scan.ranges.filter((_, beam) => beam % 2 === 0),
  angle_increment: 2 * scan.angle_increment,
}));

const POINTS: readonly PointScan[] = LASER_SCANS.map(pointsOf);
const NORMALS = { halfWidth: 2, reach: 0.3, most: 6, leastGap: 0.25, maxThickness: 0.03 };
const SURFACES: readonly SurfaceScan[] = POINTS.map((scan) => withNormals(scan, NORMALS));

/** Standard deviations of the odometry's error for each metre driven: of the distance as a share, of the heading in radians. */
export interface Noise {
  readonly way: number;
  readonly turn: number;
}

/** The noise of the first state. */
export const USUAL: Noise = { way: 0.05, turn: (4 * Math.PI) / 180 };

/** Draws of a standard normal distribution by run and step, so that another noise scales the same errors. */
const RUNS = 60;
const DRAWS: readonly (readonly Point[])[] = Array.from({ length: RUNS }, (_, run) => {
  const random = seeded(100 + run);
  return MOTIONS.map((): Point => [normal(random), normal(random)]);
});

/** The motions that the odometry measures in a run. Independent errors of the steps grow with the square root of the distance. */
function measured({ way, turn }: Noise, run: number): readonly Pose[] {
  return MOTIONS.map(([x, y, angle], k) => {
    const [a, b] = DRAWS[run]?.[k] ?? [0, 0];
    const root = Math.sqrt(Math.hypot(x, y));
    const stretch = 1 + (way * a) / Math.max(root, 1e-9);
    return [x * stretch, y * stretch, angle + turn * b * root];
  });
}

/** The poses by odometry alone. */
export const byOdometry = (size: Noise, run = 0): readonly Pose[] => chained(TRUTH[0] as Pose, measured(size, run));

/** Where other runs of the same odometry would end. */
export const otherEnds = (size: Noise): readonly Point[] =>
  Array.from({ length: RUNS - 1 }, (_, run) => {
    const [x, y] = byOdometry(size, run + 1)[SCANS - 1] as Pose;
    return [x, y];
  });

/** So many scans before one are its map; gates in metres from iteration to iteration; the share of pairs that counts. */
const BEFORE = 3;
const GATES = [1, 0.7, 0.5, 0.35, 0.25, 0.25];
const KEEP = 0.9;

function joined(scans: readonly SurfaceScan[]): SurfaceScan {
  const all = (of: (scan: SurfaceScan) => ArrayLike<number>): number[] => scans.flatMap((scan) => Array.from(of(scan)));
  return {
    x: Float64Array.from(all((scan) => scan.x)),
    y: Float64Array.from(all((scan) => scan.y)),
    nx: Float64Array.from(all((scan) => scan.nx)),
    ny: Float64Array.from(all((scan) => scan.ny)),
    isPoint: Uint8Array.from(all((scan) => scan.isPoint)),
    hasNormal: Uint8Array.from(all((scan) => scan.hasNormal)),
    sensor: [0, 0],
  };
}

/** A scan's points and normals in the frame of a pose. */
function surfaceAt(k: number, pose: Pose): SurfaceScan {
  const scan = SURFACES[k] as SurfaceScan;
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  const nx = scan.nx.map((x, i) => c * x - s * (scan.ny[i] ?? 0));
  const ny = scan.ny.map((y, i) => s * (scan.nx[i] ?? 0) + c * y);
  return { ...scan, ...placed(scan, pose), nx, ny };
}

/** The next corrected pose: odometry from the last one, then point to line against the scans before it. */
export function corrected(poses: readonly Pose[], size: Noise): Pose {
  const k = poses.length;
  const first = Math.max(0, k - BEFORE);
  const map = joined(poses.slice(first).map((pose, i) => surfaceAt(first + i, pose)));
  let pose = compose(poses[k - 1] as Pose, measured(size, 0)[k - 1] as Pose);
  for (const gate of GATES) pose = iterate("point_to_line", POINTS[k] as PointScan, pose, map, gate, KEEP);
  return pose;
}

const CONFIG = { ...INITIAL_CONFIG, update: "per_scan" } as const;

/** The map of the scans along poses. */
export function mapAlong(poses: readonly Pose[]): OccupancyGrid {
  const grid = emptyGrid(GEOMETRY);
  poses.forEach((pose, k) => {
    occupancyGridMapping(grid, THINNED[k] as LaserScan, pose, CONFIG);
  });
  return grid;
}

/** How far the poses are from the true ones: the root of the mean square, metres. */
export const errorOf = (poses: readonly Pose[]): number => rmsDistance(poses, TRUTH);
