/** The plane of a patch of terrain from its moments, as `mapper/terrain/textbook.py` computes it. */

export type Place = readonly [x: number, y: number, z: number];
/** P, 4 × 4, row by row: the sum of v vᵀ with v = [1 x y z]ᵀ. */
export type Moments = readonly number[];

export interface Plane {
  readonly a: number;
  readonly b: number;
  readonly c: number;
  readonly n: number;
  readonly meanHeight: number;
  /** Sum of the squared distances along z, m². */
  readonly residual: number;
  /** √(residual / n), m. */
  readonly roughness: number;
  /** cos⁻¹(1 / √(1 + b² + c²)), radians. */
  readonly slope: number;
}

/** Points are on a line where the determinant of their covariance is less than this times its trace squared. */
const FLATNESS = 1e-6;

export function momentsOf(points: readonly Place[]): Moments {
  const sums = new Array<number>(16).fill(0);
  for (const [x, y, z] of points) {
    const v = [1, x, y, z] as const;
    for (let row = 0; row < 4; row++)
      for (let col = 0; col < 4; col++)
        sums[4 * row + col] = (sums[4 * row + col] as number) + (v[row] as number) * (v[col] as number);
  }
  return sums;
}

const entry = (moments: Moments, row: number, col: number): number => moments[4 * row + col] as number;

/** The plane z = a + b·x + c·y of least squares; null for fewer than three points, and for points on a line. */
export function planeOf(moments: Moments): Plane | null {
  const p = (row: number, col: number): number => entry(moments, row, col);
  const n = Math.round(p(0, 0));
  if (n < 3) return null;
  // About the mean: two equations for b and c.
  const [mx, my, mz] = [p(0, 1) / n, p(0, 2) / n, p(0, 3) / n];
  const [xx, xy, yy] = [p(1, 1) - n * mx * mx, p(1, 2) - n * mx * my, p(2, 2) - n * my * my];
  const [xz, yz] = [p(1, 3) - n * mx * mz, p(2, 3) - n * my * mz];
  const det = xx * yy - xy * xy;
  if (det <= FLATNESS * (xx + yy) ** 2) return null;
  const b = (yy * xz - xy * yz) / det;
  const c = (xx * yz - xy * xz) / det;
  const a = mz - b * mx - c * my;
  const residual = Math.max(p(3, 3) - (a * p(0, 3) + b * p(1, 3) + c * p(2, 3)), 0);
  const slope = Math.acos(1 / Math.sqrt(1 + b * b + c * c));
  return { a, b, c, n, meanHeight: mz, residual, roughness: Math.sqrt(residual / n), slope };
}

/** The height of a plane at (x, y). */
export const heightAt = ({ a, b, c }: Plane, x: number, y: number): number => a + b * x + c * y;

/** The slope without the root, as one of the sources prints it: cos⁻¹(1 / (1 + b² + c²)), radians. */
export const slopeWithoutRoot = ({ b, c }: Plane): number => Math.acos(1 / (1 + b * b + c * c));

/** Planes that RANSAC tries at most; of no more triples all. */
const TRIALS = 100;

/**
 * Triples of n points for RANSAC, as `mapper/terrain/textbook.py::triples_of` has them: all in order, at most `TRIALS`,
 * else random ones that depend on n only.
 */
export function* triplesOf(n: number): Generator<readonly [number, number, number]> {
  if ((n * (n - 1) * (n - 2)) / 6 <= TRIALS) {
    for (let i = 0; i < n; i++) for (let j = i + 1; j < n; j++) for (let k = j + 1; k < n; k++) yield [i, j, k];
    return;
  }
  let state = n;
  const draw = (left: number, taken: readonly number[]): number => {
    state = (Math.imul(1664525, state) + 1013904223) >>> 0;
    let chosen = (state >>> 8) % left;
    for (const index of [...taken].sort((a, b) => a - b)) if (chosen >= index) chosen++;
    return chosen;
  };
  for (let trial = 0; trial < TRIALS; trial++) {
    const i = draw(n, []);
    const j = draw(n - 1, [i]);
    yield [i, j, draw(n - 2, [i, j])];
  }
}

/** Which points are within `distance` along z of the plane of the three points that most others agree with. */
export function consensus(points: readonly Place[], distance: number): readonly boolean[] {
  let best: readonly boolean[] = points.map(() => false);
  let most = 0;
  for (const triple of triplesOf(points.length)) {
    const plane = planeOf(momentsOf(triple.map((at) => points[at] as Place)));
    if (!plane) continue;
    const inside = points.map(([x, y, z]) => Math.abs(z - heightAt(plane, x, y)) <= distance);
    const count = inside.filter(Boolean).length;
    if (count > most) [best, most] = [inside, count];
  }
  return best;
}

export interface Limits {
  /** Slope that is unsafe by itself, radians. */
  readonly slope: number;
  /** Roughness that is unsafe by itself, m. */
  readonly roughness: number;
  /** Step that is unsafe by itself, m; without it steps do not count. */
  readonly step?: number;
  /** Weights of slope, roughness and step; without them 1. */
  readonly weights?: readonly [number, number, number];
  /** Unsafe above 1 is the greatest of the three ratios, not their sum. */
  readonly isThresholds?: boolean;
}

/** The greatest gap between a plane and its neighbours' at places of the common edges; 0 without neighbours. */
export const stepOf = (plane: Plane, edges: readonly Place[]): number =>
  Math.max(0, ...edges.map(([x, y, z]) => Math.abs(heightAt(plane, x, y) - z)));

interface Ratio {
  readonly name: string;
  /** The weight times the property, divided by its greatest safe value. */
  readonly value: number;
}

/** The ratios of slope, roughness and, where it has a limit, step. */
export function ratiosOf(plane: Plane, limits: Limits, edges: readonly Place[] = []): readonly Ratio[] {
  const [slope, roughness, step] = limits.weights ?? [1, 1, 1];
  return [
    { name: "slope", value: slope * (plane.slope / limits.slope) },
    { name: "roughness", value: roughness * (plane.roughness / limits.roughness) },
    ...(limits.step === undefined ? [] : [{ name: "step", value: step * (stepOf(plane, edges) / limits.step) }]),
  ];
}

/** The sum of the ratios, or the greatest of them; unsafe above 1. */
export function scoreOf(plane: Plane, limits: Limits, edges: readonly Place[] = []): number {
  const values = ratiosOf(plane, limits, edges).map(({ value }) => value);
  return limits.isThresholds ? Math.max(...values) : values.reduce((sum, value) => sum + value, 0);
}
