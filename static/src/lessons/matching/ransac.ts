/** A pose from pairs of points of which many are wrong. Source: Fischler & Bolles 1981. */

import { seeded } from "../../grid/random";
import type { Point, Pose } from "../../wire/protocol";
import { bestRigidMotion, type Pairs, type PointScan, placed } from "./model";

/** The first and last index of each straight part of a run of points, which is split where it is farthest from its chord. */
export function split(
  points: readonly Point[],
  thickness: number,
  fewest: number,
): readonly (readonly [number, number])[] {
  if (points.length < fewest) return [];
  const [first, last] = [points[0] as Point, points[points.length - 1] as Point];
  const [dx, dy] = [last[0] - first[0], last[1] - first[1]];
  const length = Math.hypot(dx, dy);
  const away = points.map(([x, y]) =>
    length > 0 ? Math.abs((x - first[0]) * dy - (y - first[1]) * dx) / length : Math.hypot(x - first[0], y - first[1]),
  );
  const farthest = Math.max(...away);
  if (farthest <= thickness) return [[0, points.length - 1]];
  const at = away.indexOf(farthest);
  return [
    ...split(points.slice(0, at + 1), thickness, fewest),
    ...split(points.slice(at), thickness, fewest).map(([a, b]) => [a + at, b + at] as const),
  ];
}

/** The ends of the straight parts of a scan; a gap of `gap` metres between neighbours ends a run. */
export function wallsOf(
  scan: PointScan,
  gap: number,
  thickness: number,
  fewest: number,
): readonly (readonly [Point, Point])[] {
  const runs: Point[][] = [[]];
  let before: Point | null = null;
  scan.isPoint.forEach((is, k) => {
    if (!is) return;
    const point: Point = [scan.x[k] ?? 0, scan.y[k] ?? 0];
    if (before && Math.hypot(point[0] - before[0], point[1] - before[1]) > gap) runs.push([]);
    runs[runs.length - 1]?.push(point);
    before = point;
  });
  return runs.flatMap((run) =>
    split(run, thickness, fewest).map(([a, b]) => [run[a] as Point, run[b] as Point] as const),
  );
}

interface Agreed {
  readonly pose: Pose;
  /** Of each pair, whether its points lie on one another at the pose. */
  readonly isInlier: readonly boolean[];
}

/** The pose of two pairs drawn at random at which most pairs are nearer than `gate` metres; of `draws` draws. */
export function ransac(moving: PointScan, fixed: PointScan, pairs: Pairs, gate: number, draws: number): Agreed {
  const random = seeded(1);
  const count = pairs.ours.length;
  let best: Agreed = { pose: [0, 0, 0], isInlier: [] };
  let most = -1;
  for (let draw = 0; draw < draws; draw++) {
    const [a, b] = [Math.floor(random() * count), Math.floor(random() * count)];
    if (a === b) continue;
    const pick = (of: readonly number[]): readonly number[] => [of[a] ?? 0, of[b] ?? 0];
    const pose = bestRigidMotion(moving, fixed, { ours: pick(pairs.ours), theirs: pick(pairs.theirs) });
    const at = placed(moving, pose);
    const isInlier = pairs.ours.map((k, i) => {
      const j = pairs.theirs[i] ?? 0;
      const [dx, dy] = [(at.x[k] ?? 0) - (fixed.x[j] ?? 0), (at.y[k] ?? 0) - (fixed.y[j] ?? 0)];
      return Math.hypot(dx, dy) < gate;
    });
    const inliers = isInlier.filter(Boolean).length;
    if (inliers > most) [most, best] = [inliers, { pose, isInlier }];
  }
  return best;
}
