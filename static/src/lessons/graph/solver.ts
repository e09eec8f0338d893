/**
 * Least squares over a pose graph: a TypeScript version of mapper/slam/textbook.py and of mapper/slam/optimise.py, tested
 * on the same vectors (graph.vectors.json). Sources: Grisetti et al. 2010 (the least squares), Yang et al. 2020
 * (the kernel whose scale shrinks), Zhang 1997 (the weights).
 */

import { between, wrapped } from "../../grid/poses";
import type { Pose } from "../../wire/protocol";
import type { Symmetric } from "../matching/symmetric";

/** A measured motion from node i to node j: Z ≈ Tᵢ⁻¹ ∘ Tⱼ, with its information in the frame of Z. */
export interface GraphEdge {
  readonly i: number;
  readonly j: number;
  readonly relative: Pose;
  readonly information: Symmetric;
  /** Whether the robust kernel applies to it. */
  readonly isLoop: boolean;
}

export type Kernel = "geman_mcclure" | "cauchy" | "huber" | "none";

export interface Solution {
  readonly poses: readonly Pose[];
  /** √(eᵀ Ω e) of each edge, in standard deviations. */
  readonly residuals: readonly number[];
  /** What the kernel leaves of each edge, 0 to 1. */
  readonly weights: readonly number[];
}

interface SolverOptions {
  readonly kernel: Kernel;
  /** Scale of the kernel, in standard deviations. */
  readonly scale: number;
  /** Nodes that do not move. */
  readonly fixed: readonly number[];
  readonly maxIterations?: number;
}

type Vector = readonly [number, number, number];

const MAX_ITERATIONS = 60;
/** Metres and radians: the largest step after which the poses count as found. */
const STOP = 1e-5;
/** Of the squared scale of the kernel, from one iteration to the next. */
const SHRINK = 0.25;
/** Radians: of one step, where the linearisation holds. */
const GREATEST_TURN = 0.5;

const node = (poses: readonly Pose[], k: number): Pose => poses[k] as Pose;

/** e = Z⁻¹ ∘ (Tᵢ⁻¹ ∘ Tⱼ). */
const edgeError = (poses: readonly Pose[], edge: GraphEdge): Pose =>
  between(edge.relative, between(node(poses, edge.i), node(poses, edge.j)));

const times = ([xx, xy, xt, yy, yt, tt]: Symmetric, [x, y, t]: Vector): Vector => [
  xx * x + xy * y + xt * t,
  xy * x + yy * y + yt * t,
  xt * x + yt * y + tt * t,
];
const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** eᵀ Ω e. */
function squaredError(poses: readonly Pose[], edge: GraphEdge): number {
  const error = edgeError(poses, edge);
  return dot(error, times(edge.information, error));
}

/** The columns of ∂e/∂xᵢ and ∂e/∂xⱼ, for increments that are added to x, y and θ. */
function jacobianColumns(poses: readonly Pose[], edge: GraphEdge): readonly [readonly Vector[], readonly Vector[]] {
  const [a, b] = [node(poses, edge.i), node(poses, edge.j)];
  const turn = a[2] + edge.relative[2];
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  return [
    [
      [-c, s, 0],
      [-s, -c, 0],
      [-s * dx + c * dy, -c * dx - s * dy, -1],
    ],
    [
      [c, -s, 0],
      [s, c, 0],
      [0, 0, 1],
    ],
  ];
}

/** The weight that a kernel leaves to a squared residual. Source: Zhang 1997. */
export function robustWeight(kernel: Kernel, chi2: number, scale: number): number {
  const ratio = chi2 / (scale * scale);
  if (kernel === "geman_mcclure") return 1 / (1 + ratio) ** 2;
  if (kernel === "cauchy") return 1 / (1 + ratio);
  return kernel === "huber" ? 1 / Math.sqrt(Math.max(ratio, 1)) : 1;
}

/** Solves H x = g in place by Cholesky's factorisation; H (n, n) is symmetric, positive definite, in rows. */
function solveDense(h: Float64Array, g: Float64Array): Float64Array {
  const n = g.length;
  const at = (r: number, c: number): number => h[r * n + c] ?? 0;
  for (let c = 0; c < n; c++)
    for (let r = c; r < n; r++) {
      let sum = at(r, c);
      for (let k = 0; k < c; k++) sum -= at(r, k) * at(c, k);
      h[r * n + c] = r === c ? Math.sqrt(Math.max(sum, 1e-12)) : sum / at(c, c);
    }
  const x = g.slice();
  for (let r = 0; r < n; r++) {
    for (let k = 0; k < r; k++) x[r] = (x[r] ?? 0) - at(r, k) * (x[k] ?? 0);
    x[r] = (x[r] ?? 0) / at(r, r);
  }
  for (let r = n - 1; r >= 0; r--) {
    for (let k = r + 1; k < n; k++) x[r] = (x[r] ?? 0) - at(k, r) * (x[k] ?? 0);
    x[r] = (x[r] ?? 0) / at(r, r);
  }
  return x;
}

/** The Gauss–Newton step of each node, metres and radians; fixed nodes have none. */
export function gaussNewtonStep(
  poses: readonly Pose[],
  edges: readonly GraphEdge[],
  weights: readonly number[],
  fixed: readonly number[],
): readonly Vector[] {
  const rows = new Map<number, number>();
  for (let k = 0; k < poses.length; k++) if (!fixed.includes(k)) rows.set(k, rows.size);
  const n = 3 * rows.size;
  const [h, g] = [new Float64Array(n * n), new Float64Array(n)];
  edges.forEach((edge, e) => {
    const weight = weights[e] ?? 1;
    const error = edgeError(poses, edge);
    const columns = jacobianColumns(poses, edge);
    const ends = [rows.get(edge.i), rows.get(edge.j)];
    ends.forEach((row, end) => {
      if (row === undefined) return;
      columns[end]?.forEach((column, r) => {
        const weighed = times(edge.information, column);
        g[3 * row + r] = (g[3 * row + r] ?? 0) - weight * dot(weighed, error);
        ends.forEach((other, two) => {
          if (other === undefined) return;
          columns[two]?.forEach((second, c) => {
            const index = (3 * row + r) * n + 3 * other + c;
            h[index] = (h[index] ?? 0) + weight * dot(weighed, second);
          });
        });
      });
    });
  });
  const x = n > 0 ? solveDense(h, g) : g;
  return poses.map((_, k) => {
    const row = rows.get(k);
    return row === undefined ? [0, 0, 0] : [x[3 * row] ?? 0, x[3 * row + 1] ?? 0, x[3 * row + 2] ?? 0];
  });
}

/** A share of a step, and less of it where it would turn a node too far. */
export function moved(poses: readonly Pose[], step: readonly Vector[], share = 1): readonly Pose[] {
  const turn = Math.max(...step.map(([, , t]) => Math.abs(t)));
  const part = share * Math.min(1, GREATEST_TURN / Math.max(turn, 1e-300));
  return poses.map(([x, y, t], k) => {
    const [dx, dy, dt] = step[k] as Vector;
    return [x + part * dx, y + part * dy, t + part * dt];
  });
}

/** The residuals and weights of the edges at given poses. */
export function judge(
  poses: readonly Pose[],
  edges: readonly GraphEdge[],
  kernel: Kernel,
  scale: number,
): Omit<Solution, "poses"> {
  const squares = edges.map((edge) => squaredError(poses, edge));
  const weights = squares.map((chi2, e) => (edges[e]?.isLoop ? robustWeight(kernel, chi2, scale) : 1));
  return { residuals: squares.map(Math.sqrt), weights };
}

/** The poses with the least Σ ρ(eᵀ Ω e); the scale of the kernel begins at the largest residual and shrinks. */
export function optimise(start: readonly Pose[], edges: readonly GraphEdge[], options: SolverOptions): Solution {
  const { kernel, scale, fixed, maxIterations = MAX_ITERATIONS } = options;
  let poses = start;
  const robust = edges.filter((edge) => edge.isLoop && kernel !== "none");
  const worst = Math.max(0, ...robust.map((edge) => squaredError(poses, edge)));
  let widening = Math.max(1, (2 * worst) / (scale * scale));
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const { weights } = judge(poses, edges, kernel, scale * Math.sqrt(widening));
    const step = gaussNewtonStep(poses, edges, weights, fixed);
    poses = moved(poses, step);
    const largest = Math.max(...step.map((matrixRow) => Math.max(...matrixRow.map(Math.abs))));
    if (widening === 1 && largest < STOP) break;
    widening = Math.max(1, SHRINK * widening);
  }
  poses = poses.map(([x, y, t]) => [x, y, wrapped(t)]);
  return { poses, ...judge(poses, edges, kernel, scale) };
}
