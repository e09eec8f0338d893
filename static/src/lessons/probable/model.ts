/**
 * The most probable position along a corridor: the likelihood of a scan in a map times what the odometry says.
 *
 * Source: Probabilistic Robotics, chapter 6 (the likelihood field: a normal distribution of the distance from each end
 * point to the nearest wall, and a small constant for readings that the map does not explain).
 */

import type { GridGeometry } from "../../grid/occupancyGrid";
import { seeded } from "../../grid/random";
import { bearingOf } from "../../grid/textbook";
import type { Point } from "../../wire/protocol";
import { allRound, scanFrom, type Wall } from "../common/world";

export const GEOMETRY: GridGeometry = { resolution: 0.1, rows: 24, cols: 96, origin: [0, -0.2, 0] };
const Y = 1;
/** Positions that are compared, metres along the corridor. */
export const FIRST = 0.8;
export const LAST = 8.8;
const STEP = 0.02;
export const POSITIONS: readonly number[] = Array.from(
  { length: Math.round((LAST - FIRST) / STEP) + 1 },
  (_, k) => FIRST + STEP * k,
);

const straight: readonly Wall[] = [
  [-3, 0, 13, 0],
  [-3, 2, 13, 2],
];
/** A wall along x with recesses, each 0.7 m wide and 0.35 m deep. */
function withDoors(at: readonly number[], y: number, deep: number): readonly Wall[] {
  const walls: Wall[] = [];
  let from = -3;
  for (const door of at) {
    walls.push([from, y, door, y], [door, y, door, y + deep], [door, y + deep, door + 0.7, y + deep]);
    walls.push([door + 0.7, y + deep, door + 0.7, y]);
    from = door + 0.7;
  }
  return [...walls, [from, y, 13, y]];
}

const PLACES = {
  cabinets: [
    ...straight,
    [3.2, 0, 3.2, 0.5],
    [3.2, 0.5, 4.1, 0.5],
    [4.1, 0.5, 4.1, 0],
    [6.3, 2, 6.3, 1.6],
    [6.3, 1.6, 6.8, 1.6],
    [6.8, 1.6, 6.8, 2],
  ],
  doors: [...withDoors([-1.5, 0.5, 2.5, 4.5, 6.5, 8.5], 2, 0.2), [-3, 0, 13, 0]],
  bare: straight,
} satisfies Record<string, readonly Wall[]>;

export type PlaceName = keyof typeof PLACES;

export interface Place {
  readonly walls: readonly Wall[];
  /** Where the scan was taken, metres. */
  readonly truth: number;
  /** Its end points, from the robot. */
  readonly points: readonly Point[];
}

const BEAMS = 24;
const RANGE = 3;

export function placeOf(name: PlaceName): Place {
  const walls = PLACES[name];
  const truth = 4.7;
  const scan = scanFrom(walls, [truth, Y, 0.1], {
    ...allRound(BEAMS, RANGE),
    noise: { sigma: 0.01, random: seeded(8) },
  });
  const points = Array.from(scan.ranges, (r, k): Point => {
    const angle = 0.1 + bearingOf(scan, k);
    return [r * Math.cos(angle), Y + r * Math.sin(angle)];
  });
  return { walls, truth, points: points.filter(([x]) => Number.isFinite(x)) };
}

function toWall([x, y]: Point, [x0, y0, x1, y1]: Wall): number {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const t = Math.max(0, Math.min(1, ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)));
  return Math.hypot(x - x0 - t * dx, y - y0 - t * dy);
}

/** Share of readings that the map does not explain. */
const RANDOM = 0.05;

/** Squared distance to the nearest wall of each end point, position by position, m²; they do not depend on sigma. */
export function squaredDistances({ walls, points }: Place): Float64Array {
  const squares = new Float64Array(POSITIONS.length * points.length);
  let k = 0;
  for (const x of POSITIONS) {
    for (const [px, py] of points) {
      let least = Number.POSITIVE_INFINITY;
      for (const wall of walls) least = Math.min(least, toWall([x + px, py], wall));
      squares[k++] = least * least;
    }
  }
  return squares;
}

/**
 * p(z | x, m) of each position, relative to the greatest, from {@link squaredDistances}; `sigma` is the uncertainty of
 * a reading, metres.
 */
export function likelihood(squares: Float64Array, sigma: number): Float64Array {
  const each = squares.length / POSITIONS.length;
  const scale = -1 / (2 * sigma * sigma);
  const logs = Float64Array.from(POSITIONS, (_, k) => {
    let sum = 0;
    for (let i = k * each; i < (k + 1) * each; i++) {
      sum += Math.log((1 - RANDOM) * Math.exp((squares[i] ?? 0) * scale) + RANDOM);
    }
    return sum;
  });
  return relative(logs);
}

/** p(x | u, x̂) of each position, relative to the greatest: a normal distribution about what the odometry says. */
export const motionModel = (mean: number, sigma: number): Float64Array =>
  relative(Float64Array.from(POSITIONS, (x) => -((x - mean) ** 2) / (2 * sigma * sigma)));

function relative(logs: Float64Array): Float64Array {
  const most = logs.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY);
  return logs.map((log) => Math.exp(log - most));
}

/** The product of both, relative to its greatest value, and the position that has it. */
export function posterior(a: Float64Array, b: Float64Array): { readonly values: Float64Array; readonly best: number } {
  const values = relative(a.map((value, k) => Math.log(Math.max(value * (b[k] ?? 0), 1e-300))));
  return { values, best: POSITIONS[values.indexOf(1)] ?? FIRST };
}
