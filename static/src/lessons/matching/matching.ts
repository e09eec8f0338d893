/** What the figure does with two scans: a match by a method, its result, and the score fields. */

import { centreOf } from "../../grid/lattice";
import type { GridGeometry } from "../../grid/occupancyGrid";
import { wrapped } from "../../grid/poses";
import type { Pose } from "../../wire/protocol";
import {
  iterate,
  type LocalMethod,
  leastKnown,
  lineEquations,
  nearestPairs,
  type Pairs,
  scoresInWindow,
  searchWindow,
} from "./model";
import { FIELD, GEOMETRY, type Problem } from "./world";

export type Method = LocalMethod | "correlative";

const DEGREE = Math.PI / 180;
/** Points farther apart make no pair, metres; and this share of the pairs is kept. */
const GATE = 1;
const KEEP = 0.9;
const MAX_ITERATIONS = 40;
/** Metres and radians: the step after which a pose counts as found. */
const STOP = 1e-4;
/** The correlative search: cells of the field to each side, and its turns. */
export const WINDOW_CELLS = 8;
export const WINDOW_TURN = 30;
const TURNS = Array.from({ length: 25 }, (_, i) => (i - 12) * (WINDOW_TURN / 12) * DEGREE);
/** A direction with a smaller share of the information is not known, as in mapper/matching/parameters.py. */
const LEAST_INFORMATION = 0.03;

/** A match counts as found within this of the true pose: metres, radians. */
const FOUND = { distance: 0.1, turn: 4 * DEGREE };
/** A match this near to the hand snaps: metres, radians, and the least score. */
const SNAP = { distance: 0.4, turn: 25 * DEGREE, score: 0.55 };

/** How far one pose is from another: metres, and radians from 0 to π. */
export const apart = (a: Pose, b: Pose): { readonly distance: number; readonly turn: number } => ({
  distance: Math.hypot(a[0] - b[0], a[1] - b[1]),
  turn: Math.abs(wrapped(a[2] - b[2])),
});

const within = (a: Pose, b: Pose, limit: { readonly distance: number; readonly turn: number }): boolean => {
  const { distance, turn } = apart(a, b);
  return distance <= limit.distance && turn <= limit.turn;
};

/** One iteration of a method; for the correlative search it is the whole search. */
export function oneStep({ fixed, moving, scores }: Problem, method: Method, pose: Pose): Pose {
  const next =
    method === "correlative"
      ? searchWindow(scores, FIELD, moving, pose, TURNS, WINDOW_CELLS).pose
      : iterate(method, moving, pose, fixed, GATE, KEEP);
  return [next[0], next[1], wrapped(next[2])];
}

/** The pose at which a method ends, and after how many iterations. */
export function toTheEnd(
  problem: Problem,
  method: Method,
  start: Pose,
): { readonly pose: Pose; readonly steps: number } {
  if (method === "correlative") return { pose: oneStep(problem, method, start), steps: 1 };
  let pose = start;
  for (let steps = 1; steps <= MAX_ITERATIONS; steps++) {
    const next = oneStep(problem, method, pose);
    const { distance, turn } = apart(next, pose);
    pose = next;
    if (Math.max(distance, turn) < STOP) return { pose, steps };
  }
  return { pose, steps: MAX_ITERATIONS };
}

/** The greatest sum of scores that a scan can have. */
const bestSum = ({ moving }: Problem): number => 255 * moving.isPoint.reduce((sum, is) => sum + is, 0);

/** The score of a pose, 0 to 1: how near the end points lie to those of the fixed scan. */
export const scoreAt = (problem: Problem, pose: Pose): number =>
  (scoresInWindow(problem.scores, FIELD, problem.moving, pose, [0, 0, 0, 0])[0] ?? 0) / bestSum(problem);

/** The score of every position of the figure at a heading, 0 to 1, by cell. */
export function scoreLandscape(problem: Problem, heading: number): Float32Array {
  const [right, up] = [GEOMETRY.cols / 2, GEOMETRY.rows / 2];
  const [x, y] = centreOf(GEOMETRY, { col: right, row: up });
  const around = [right, right - 1, up, up - 1] as const;
  const total = bestSum(problem);
  return Float32Array.from(
    scoresInWindow(problem.scores, FIELD, problem.moving, [x, y, heading], around),
    (sum) => sum / total,
  );
}

/** The pose to which a scan held at `hand` snaps, null if there is none near. */
export function snapped(problem: Problem, method: Method, hand: Pose): Pose | null {
  const { pose } = toTheEnd(problem, method, hand);
  return within(pose, hand, SNAP) && scoreAt(problem, pose) >= SNAP.score ? pose : null;
}

/** The result at a pose: its pairs, and the motion that the pairs do not determine, if there is one. */
export function judged(
  { fixed, moving }: Problem,
  pose: Pose,
): { readonly pairs: Pairs; readonly unknown: readonly [number, number, number] | null } {
  const pairs = nearestPairs(moving, pose, fixed, GATE);
  if (pairs.ours.length < 3) return { pairs, unknown: null };
  const { share, direction } = leastKnown(lineEquations(moving, pose, fixed, pairs).h, moving);
  return { pairs, unknown: share < LEAST_INFORMATION ? direction : null };
}

/** The starting points of a basin of attraction, one per cell. */
export const STARTS: GridGeometry = { resolution: 0.2, rows: 24, cols: 32, origin: [0, 0, 0] };

/** Where a start ends: at the true pose, or elsewhere; 0 is not computed yet. */
export const TRUE_POSE = 1;
export const ELSEWHERE = 2;

/** How the match ends that starts in cell `index` of {@link STARTS} at a heading. */
export function endOf(problem: Problem, method: Method, heading: number, index: number): number {
  const [x, y] = centreOf(STARTS, { row: Math.floor(index / STARTS.cols), col: index % STARTS.cols });
  const { pose } = toTheEnd(problem, method, [x, y, heading]);
  return within(pose, problem.truth, FOUND) ? TRUE_POSE : ELSEWHERE;
}
