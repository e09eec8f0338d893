/** Symmetric matrices of three rows, by their upper triangle: xx, xy, xt, yy, yt, tt. */

type Vector = readonly [number, number, number];

export type Symmetric = readonly [xx: number, xy: number, xt: number, yy: number, yt: number, tt: number];

const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Smallest determinant, as a share of the product of the diagonal, with which a system counts as solvable. */
const SINGULAR = 1e-9;

/** The solution of H x = g by Cramer's rule; null where H is singular. */
export function solve([xx, xy, xt, yy, yt, tt]: Symmetric, g: Vector): Vector | null {
  const [a, b, c]: Vector[] = [
    [xx, xy, xt],
    [xy, yy, yt],
    [xt, yt, tt],
  ];
  if (!a || !b || !c) return null;
  const determinant = dot(a, cross(b, c));
  if (Math.abs(determinant) <= SINGULAR * xx * yy * tt) return null;
  return [dot(g, cross(b, c)) / determinant, dot(g, cross(c, a)) / determinant, dot(g, cross(a, b)) / determinant];
}

/** The least eigenvalue and its unit vector, by Jacobi's rotations (Golub & Van Loan, Matrix Computations, 8.5). */
export function leastEigen([xx, xy, xt, yy, yt, tt]: Symmetric): { readonly value: number; readonly vector: Vector } {
  const m = [
    [xx, xy, xt],
    [xy, yy, yt],
    [xt, yt, tt],
  ];
  const v = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  const get = (matrix: number[][], i: number, j: number): number => matrix[i]?.[j] ?? 0;
  const turnColumns = (matrix: number[][], p: number, q: number, c: number, s: number): void => {
    for (const row of matrix) {
      const [a, b] = [row[p] ?? 0, row[q] ?? 0];
      [row[p], row[q]] = [c * a - s * b, s * a + c * b];
    }
  };
  const turnRows = (matrix: number[][], p: number, q: number, c: number, s: number): void => {
    for (let k = 0; k < 3; k++) {
      const [a, b] = [get(matrix, p, k), get(matrix, q, k)];
      (matrix[p] as number[])[k] = c * a - s * b;
      (matrix[q] as number[])[k] = s * a + c * b;
    }
  };
  for (let sweep = 0; sweep < 12; sweep++)
    for (const [p, q] of [
      [0, 1],
      [0, 2],
      [1, 2],
    ] as const) {
      if (get(m, p, q) === 0) continue;
      const angle = 0.5 * Math.atan2(2 * get(m, p, q), get(m, q, q) - get(m, p, p));
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      turnColumns(m, p, q, c, s);
      turnRows(m, p, q, c, s);
      turnColumns(v, p, q, c, s);
    }
  const values = [0, 1, 2].map((i) => get(m, i, i));
  const i = values.indexOf(Math.min(...values));
  return { value: values[i] ?? 0, vector: [get(v, 0, i), get(v, 1, i), get(v, 2, i)] };
}
