/**
 * Scan matching in the plane: TypeScript versions of the functions in mapper/matching/textbook.py, tested on the same
 * vectors (matching.vectors.json). Sources: Besl & McKay 1992 and Arun, Huang & Blostein 1987 (point to point), Censi
 * 2008 (point to line), Chetverikov et al. 2002 (trimming), Olson 2009 (correlative).
 */

import { toLattice } from "../../grid/lattice";
import type { GridGeometry, LaserScan } from "../../grid/occupancyGrid";
import { bearingOf } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import { leastEigen, type Symmetric, solve } from "./symmetric";

/** End points of an all-round scan by beam, metres; where `isPoint` is 0 the beam has none. */
export interface PointScan {
  readonly x: Float64Array;
  readonly y: Float64Array;
  readonly isPoint: Uint8Array;
  /** Where the sensor is, in the frame of the points. */
  readonly sensor: Point;
}

/** A scan with the unit normal of the surface at each point, where one was found. */
export interface SurfaceScan extends PointScan {
  readonly nx: Float64Array;
  readonly ny: Float64Array;
  readonly hasNormal: Uint8Array;
}

/** Which points are neighbours, and which neighbours lie on a line. Metres. */
interface NormalSettings {
  readonly halfWidth: number;
  readonly reach: number;
  readonly most: number;
  readonly leastGap: number;
  readonly maxThickness: number;
}

/** Beams of the moving and of the fixed scan whose points correspond. */
export interface Pairs {
  readonly ours: readonly number[];
  readonly theirs: readonly number[];
}

export type LocalMethod = "point_to_point" | "point_to_line";

const at = (values: ArrayLike<number>, i: number): number => values[i] ?? 0;

/** The end points of a scan, in the frame of the sensor. */
export function pointsOf(scan: LaserScan): PointScan {
  const along = (part: (angle: number) => number): Float64Array =>
    Float64Array.from(scan.ranges, (r, k) => (Number.isFinite(r) ? r * part(bearingOf(scan, k)) : 0));
  return {
    x: along(Math.cos),
    y: along(Math.sin),
    isPoint: Uint8Array.from(scan.ranges, (r) => (Number.isFinite(r) ? 1 : 0)),
    sensor: [0, 0],
  };
}

/** A scan with its points moved from its own frame to that of `pose`. */
export function placed(scan: PointScan, pose: Pose): PointScan {
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  const move = (x: number, y: number): Point => [pose[0] + c * x - s * y, pose[1] + s * x + c * y];
  const x = scan.x.map((value, k) => move(value, at(scan.y, k))[0]);
  const y = scan.y.map((value, k) => move(at(scan.x, k), value)[1]);
  return { x, y, isPoint: scan.isPoint, sensor: move(...scan.sensor) };
}

/** The normals of a scan's points: across the direction in which a point and its neighbours scatter most. */
export function withNormals(scan: PointScan, settings: NormalSettings): SurfaceScan {
  const n = scan.x.length;
  const step = (2 * Math.PI) / n;
  const [nx, ny, hasNormal] = [new Float64Array(n), new Float64Array(n), new Uint8Array(n)];
  for (let k = 0; k < n; k++) {
    if (!scan.isPoint[k]) continue;
    const [toX, toY] = [at(scan.x, k) - scan.sensor[0], at(scan.y, k) - scan.sensor[1]];
    const r = Math.hypot(toX, toY);
    const reachInBeams = Math.trunc(Math.min(settings.reach / Math.max(r * step, 1e-9), settings.most));
    const half = Math.min(Math.max(settings.halfWidth, reachInBeams), Math.floor((n - 1) / 2));
    const gap = Math.max(settings.leastGap, 3 * r * step);
    let [count, sx, sy, sxx, sxy, syy] = [0, 0, 0, 0, 0, 0];
    for (let off = -half; off <= half; off++) {
      const beam = (k + off + n) % n;
      const [dx, dy] = [at(scan.x, beam) - at(scan.x, k), at(scan.y, beam) - at(scan.y, k)];
      if (!scan.isPoint[beam] || Math.hypot(dx, dy) >= gap * Math.max(Math.abs(off), 1)) continue;
      count += 1;
      [sx, sy] = [sx + dx, sy + dy];
      [sxx, sxy, syy] = [sxx + dx * dx, sxy + dx * dy, syy + dy * dy];
    }
    if (count < 3) continue;
    const [mx, my] = [sx / count, sy / count];
    const [cxx, cxy, cyy] = [sxx / count - mx * mx, sxy / count - mx * my, syy / count - my * my];
    const along = 0.5 * Math.atan2(2 * cxy, cxx - cyy);
    const [ux, uy] = [-Math.sin(along), Math.cos(along)];
    const across = cxx * ux * ux + 2 * cxy * ux * uy + cyy * uy * uy;
    if (cxx + cyy - across <= 8 * across && across >= settings.maxThickness ** 2) continue;
    const sign = ux * toX + uy * toY > 0 ? -1 : 1;
    [nx[k], ny[k], hasNormal[k]] = [sign * ux, sign * uy, 1];
  }
  return { ...scan, nx, ny, hasNormal };
}

/** Each point of `moving` at `pose` with the nearest point of `fixed` that has a normal, if that is within `gate`. */
export function nearestPairs(moving: PointScan, pose: Pose, fixed: SurfaceScan, gate: number): Pairs {
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  const { x, y, hasNormal } = fixed;
  const [ours, theirs]: [number[], number[]] = [[], []];
  for (let k = 0; k < moving.x.length; k++) {
    if (!moving.isPoint[k]) continue;
    const px = pose[0] + c * at(moving.x, k) - s * at(moving.y, k);
    const py = pose[1] + s * at(moving.x, k) + c * at(moving.y, k);
    let best = -1;
    let nearest = gate * gate;
    for (let j = 0; j < hasNormal.length; j++) {
      if (hasNormal[j] !== 1) continue;
      const dx = (x[j] ?? 0) - px;
      const dy = (y[j] ?? 0) - py;
      const square = dx * dx + dy * dy;
      if (square < nearest) {
        best = j;
        nearest = square;
      }
    }
    if (best < 0) continue;
    ours.push(k);
    theirs.push(best);
  }
  return { ours, theirs };
}

/** The `share` of the pairs whose residuals are smallest, at least one. */
export function trimmed(pairs: Pairs, residuals: readonly number[], share: number): Pairs {
  const squares = residuals.map((e) => e * e);
  const rank = Math.min(Math.max(Math.trunc(share * squares.length), 1), squares.length) - 1;
  const limit = [...squares].sort((a, b) => a - b)[rank] ?? 0;
  const within = (beams: readonly number[]): readonly number[] => beams.filter((_, i) => at(squares, i) <= limit);
  return share >= 1 ? pairs : { ours: within(pairs.ours), theirs: within(pairs.theirs) };
}

/** The distance of each pair: to the point, or to the line through it, signed. */
export function residuals(
  method: LocalMethod,
  moving: PointScan,
  pose: Pose,
  fixed: SurfaceScan,
  pairs: Pairs,
): readonly number[] {
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  return pairs.ours.map((k, i) => {
    const j = pairs.theirs[i] ?? 0;
    const dx = pose[0] + c * at(moving.x, k) - s * at(moving.y, k) - at(fixed.x, j);
    const dy = pose[1] + s * at(moving.x, k) + c * at(moving.y, k) - at(fixed.y, j);
    return method === "point_to_point" ? Math.hypot(dx, dy) : at(fixed.nx, j) * dx + at(fixed.ny, j) * dy;
  });
}

/** H = Σ JᵀJ and −Σ Jᵀe of the distances to the lines: the Gauss–Newton step of x, y, θ solves H dx = −Σ Jᵀe. */
export function lineEquations(
  moving: PointScan,
  pose: Pose,
  fixed: SurfaceScan,
  pairs: Pairs,
): { readonly h: Symmetric; readonly g: readonly [number, number, number] } {
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  const errors = residuals("point_to_line", moving, pose, fixed, pairs);
  let [xx, xy, xt, yy, yt, tt, gx, gy, gt] = [0, 0, 0, 0, 0, 0, 0, 0, 0];
  pairs.ours.forEach((k, i) => {
    const j = pairs.theirs[i] ?? 0;
    const [nx, ny, e] = [at(fixed.nx, j), at(fixed.ny, j), errors[i] ?? 0];
    const turned = [c * at(moving.x, k) - s * at(moving.y, k), s * at(moving.x, k) + c * at(moving.y, k)] as const;
    const t = ny * turned[0] - nx * turned[1];
    [xx, xy, xt] = [xx + nx * nx, xy + nx * ny, xt + nx * t];
    [yy, yt, tt] = [yy + ny * ny, yt + ny * t, tt + t * t];
    [gx, gy, gt] = [gx - nx * e, gy - ny * e, gt - t * e];
  });
  return { h: [xx, xy, xt, yy, yt, tt], g: [gx, gy, gt] };
}

/** The pose with the least sum of squared distances between the points of pairs, in closed form. */
export function bestRigidMotion(moving: PointScan, fixed: PointScan, { ours, theirs }: Pairs): Pose {
  const mean = (values: Float64Array, beams: readonly number[]): number =>
    beams.reduce((sum, beam) => sum + at(values, beam), 0) / beams.length;
  const [px, py] = [mean(moving.x, ours), mean(moving.y, ours)];
  const [qx, qy] = [mean(fixed.x, theirs), mean(fixed.y, theirs)];
  let [cross, dot] = [0, 0];
  ours.forEach((k, i) => {
    const j = theirs[i] ?? 0;
    const [ax, ay] = [at(moving.x, k) - px, at(moving.y, k) - py];
    const [bx, by] = [at(fixed.x, j) - qx, at(fixed.y, j) - qy];
    cross += ax * by - ay * bx;
    dot += ax * bx + ay * by;
  });
  const theta = Math.atan2(cross, dot);
  const [c, s] = [Math.cos(theta), Math.sin(theta)];
  return [qx - (c * px - s * py), qy - (s * px + c * py), theta];
}

/** One iteration of ICP: pairs of nearest points, the best `keep` of them, and the pose that fits these best. */
export function iterate(
  method: LocalMethod,
  moving: PointScan,
  pose: Pose,
  fixed: SurfaceScan,
  gate: number,
  keep: number,
): Pose {
  const all = nearestPairs(moving, pose, fixed, gate);
  if (all.ours.length < 3) return pose;
  const pairs = trimmed(all, residuals(method, moving, pose, fixed, all), keep);
  if (method === "point_to_point") return bestRigidMotion(moving, fixed, pairs);
  const { h, g } = lineEquations(moving, pose, fixed, pairs);
  const step = solve(h, g);
  return step ? [pose[0] + step[0], pose[1] + step[1], pose[2] + step[2]] : pose;
}

/** Scores 0–255 of the cells near points: 255 · exp(−d² / 2σ²) of the nearest one, up to `reach` cells away. */
export function scoreField(
  geometry: GridGeometry,
  scan: PointScan,
  sigma: number,
  fine: number,
  reach: number,
): Uint8Array {
  const { rows, cols, resolution } = geometry;
  const scores = new Uint8Array(rows * cols);
  scan.isPoint.forEach((is, k) => {
    const [col, row] = toLattice(geometry, at(scan.x, k), at(scan.y, k));
    const [atCol, atRow] = [Math.floor(col), Math.floor(row)];
    if (!is || atCol < 0 || atRow < 0 || atCol >= cols || atRow >= rows) return;
    const placeCol = (Math.floor((col - atCol) * fine) + 0.5) / fine;
    const placeRow = (Math.floor((row - atRow) * fine) + 0.5) / fine;
    for (let r = Math.max(atRow - reach, 0); r <= Math.min(atRow + reach, rows - 1); r++)
      for (let c = Math.max(atCol - reach, 0); c <= Math.min(atCol + reach, cols - 1); c++) {
        const dRow = (r - atRow + 0.5 - placeRow) * resolution;
        const dCol = (c - atCol + 0.5 - placeCol) * resolution;
        const score = Math.trunc(255 * Math.exp(-(dRow * dRow + dCol * dCol) / (2 * sigma * sigma)));
        const index = r * cols + c;
        if (score > at(scores, index)) scores[index] = score;
      }
  });
  return scores;
}

/** Cells to the left, right, below and above a pose. */
export type Window = readonly [left: number, right: number, down: number, up: number];

/**
 * The score of each pose in a window around `pose`, row by row from its lower left: the sum of the scores of the cells
 * that hold the points there. The points are turned first, and then moved by whole cells.
 */
export function scoresInWindow(
  scores: Uint8Array,
  geometry: GridGeometry,
  scan: PointScan,
  pose: Pose,
  [left, right, down, up]: Window,
): Int32Array {
  const { rows, cols } = geometry;
  const [wide, high] = [left + right + 1, down + up + 1];
  const out = new Int32Array(wide * high);
  const turned = placed(scan, pose);
  for (let k = 0; k < turned.x.length; k++) {
    if (!turned.isPoint[k]) continue;
    const [u, v] = toLattice(geometry, at(turned.x, k), at(turned.y, k));
    const col = Math.floor(u) - left;
    const row = Math.floor(v) - down;
    const [first, last] = [Math.max(0, -col), Math.min(wide, cols - col)];
    const top = Math.min(high, rows - row);
    for (let r = Math.max(0, -row); r < top; r++) {
      const from = (row + r) * cols + col;
      for (let c = first; c < last; c++) {
        const index = r * wide + c;
        out[index] = (out[index] ?? 0) + (scores[from + c] ?? 0);
      }
    }
  }
  return out;
}

/** The pose with the greatest score among `turns` and the cells up to `cells` away; of equal ones the first. */
export function searchWindow(
  scores: Uint8Array,
  geometry: GridGeometry,
  scan: PointScan,
  pose: Pose,
  turns: readonly number[],
  cells: number,
): { readonly pose: Pose; readonly score: number } {
  let best: { pose: Pose; score: number } = { pose, score: -1 };
  const wide = 2 * cells + 1;
  for (const turn of turns) {
    const turned: Pose = [pose[0], pose[1], pose[2] + turn];
    scoresInWindow(scores, geometry, scan, turned, [cells, cells, cells, cells]).forEach((score, i) => {
      if (score <= best.score) return;
      const [col, row] = [(i % wide) - cells, Math.floor(i / wide) - cells];
      const moved: Pose = [pose[0] + col * geometry.resolution, pose[1] + row * geometry.resolution, turned[2]];
      best = { pose: moved, score };
    });
  }
  return best;
}

/**
 * The least share of the information that a direction has, and that direction (x, y, θ), of length 1. The angle is
 * scaled by the root mean square distance of the points, as in mapper/matching/match.py.
 */
export function leastKnown(
  h: Symmetric,
  moving: PointScan,
): { readonly share: number; readonly direction: readonly [number, number, number] } {
  let [squares, count] = [0, 0];
  moving.isPoint.forEach((is, k) => {
    if (!is) return;
    squares += at(moving.x, k) ** 2 + at(moving.y, k) ** 2;
    count += 1;
  });
  const lever = Math.max(Math.sqrt(squares / Math.max(count, 1)), 1e-3);
  const [xx, xy, xt, yy, yt, tt] = h;
  if (xx + yy <= 0) return { share: 0, direction: [1, 0, 0] };
  const { value, vector } = leastEigen([xx, xy, xt / lever, yy, yt / lever, tt / (lever * lever)]);
  const scaled = [vector[0], vector[1], vector[2] / lever] as const;
  const length = Math.hypot(...scaled);
  return {
    share: Math.max(value, 0) / (xx + yy),
    direction: [scaled[0] / length, scaled[1] / length, scaled[2] / length],
  };
}
