/**
 * A robot in a corridor with three doors, its belief as a histogram and as particles.
 *
 * Sources: Probabilistic Robotics, table 8.1 (grid localization) for the histogram, tables 8.2 and 4.4 for the
 * particles. Metres along the corridor.
 */

import { signal } from "@preact/signals";
import { independentSampler, lowVarianceSampler, normalized } from "../../grid/particleFilter";
import { normal, seeded } from "../../grid/random";

export const LENGTH = 12;
export const DOORS: readonly number[] = [2, 5, 9.5];
export const DOOR_WIDTH = 0.9;
const CELL = 0.05;
const CELLS = Math.round(LENGTH / CELL);
/** A drive, and the standard deviation of its error. */
export const DRIVEN = 1;
const SIGMA = 0.12;
/** Ends of the corridor at which the robot turns round. */
const END = 0.6;
/** Probability that the sensor says "door" in front of one, and far from one. */
const SEEN = 0.9;
const FALSE = 0.05;

/** p(door | x): smooth at the frame of a door. */
const doorLikelihood = (x: number): number => {
  const nearest = Math.min(...DOORS.map((door) => Math.abs(x - door)));
  return FALSE + (SEEN - FALSE) / (1 + Math.exp((nearest - DOOR_WIDTH / 2) / 0.06));
};

/** Whether the sensor of a robot at x says "door": it makes no mistake here. */
export const seesDoor = (x: number): boolean => DOORS.some((door) => Math.abs(x - door) <= DOOR_WIDTH / 2);

const likelihood = (x: number, door: boolean): number => (door ? doorLikelihood(x) : 1 - doorLikelihood(x));

export type Phase = "weighed" | "drawn" | "moved";
export type Draw = "low_variance" | "independent";

export interface Filter {
  readonly phase: Phase;
  /** Number of steps so far: the seed of the next one. */
  readonly step: number;
  readonly robot: number;
  /** The histogram before the reading, Σ = 1, and the particles. */
  readonly prior: Float64Array;
  readonly particles: Float64Array;
}

export const centre = (cell: number): number => (cell + 0.5) * CELL;

/** Width of the bins that KLD sampling counts, m, and their number. */
const BIN = 0.5;
export const BINS = LENGTH / BIN;

/** The number of bins in which there is a particle. */
export const occupiedBins = ({ particles }: Filter): number =>
  new Set(
    Array.from(
      particles.filter((x) => x >= 0 && x < LENGTH),
      (x) => Math.floor(x / BIN),
    ),
  ).size;

/** Nothing is known of the position, and the robot stands at the first door. */
export function start(count: number): Filter {
  return {
    phase: "weighed",
    step: 0,
    robot: DOORS[0] ?? 0,
    prior: new Float64Array(CELLS).fill(1 / CELLS),
    particles: Float64Array.from({ length: count }, (_, i) => ((i + 0.5) * LENGTH) / count),
  };
}

/** The histogram after the reading, where there is one; Σ = 1. */
export function belief({ phase, prior, robot }: Filter): Float64Array {
  if (phase === "moved") return prior;
  const door = seesDoor(robot);
  return normalized(prior.map((p, i) => p * likelihood(centre(i), door)));
}

/** The weights of the particles, Σ = 1: by the reading, or all equal. */
export function weights({ phase, particles, robot }: Filter): Float64Array {
  if (phase !== "weighed") return new Float64Array(particles.length).fill(1 / particles.length);
  const door = seesDoor(robot);
  return normalized(particles.map((x) => (x < 0 || x > LENGTH ? 0 : likelihood(x, door))));
}

/** Which particles a draw takes. The low-variance sampler’s first pointer is at `share` of the distance of two. */
export function drawnOf(filter: Filter, draw: Draw, share: number): Int32Array {
  const count = filter.particles.length;
  return draw === "low_variance"
    ? lowVarianceSampler(weights(filter), share / count, count)
    : independentSampler(weights(filter), seeded(77 + filter.step), count);
}

/** The next step: resample, drive, weigh. */
export function next(filter: Filter, draw: Draw, share: number): Filter {
  const step = filter.step + 1;
  if (filter.phase === "weighed") {
    const drawn = drawnOf(filter, draw, share);
    const particles = Float64Array.from(drawn, (i) => filter.particles[i] ?? 0);
    return { ...filter, phase: "drawn", step, particles, prior: belief(filter), robot: filter.robot };
  }
  if (filter.phase === "moved") return { ...filter, phase: "weighed", step };
  const by = filter.robot + DRIVEN > LENGTH - END ? -DRIVEN : DRIVEN;
  const random = seeded(500 + step);
  return {
    phase: "moved",
    step,
    robot: filter.robot + by,
    prior: moved(filter.prior, by),
    particles: filter.particles.map((x) => x + by + SIGMA * normal(random)),
  };
}

/** The histogram after a drive: table 8.1, line 3. What leaves the corridor is impossible. */
function moved(prior: Float64Array, by: number): Float64Array {
  const shift = Math.round(by / CELL);
  const reach = Math.ceil((3 * SIGMA) / CELL);
  const kernel = Array.from({ length: 2 * reach + 1 }, (_, k) => Math.exp(-0.5 * (((k - reach) * CELL) / SIGMA) ** 2));
  const out = new Float64Array(CELLS);
  prior.forEach((p, i) => {
    kernel.forEach((g, k) => {
      const to = i + shift + k - reach;
      if (to >= 0 && to < CELLS) out[to] = (out[to] ?? 0) + p * g;
    });
  });
  return normalized(out);
}

/** How many particles it begins with. */
export const COUNT = 24;
/** The filter of the corridor, which two figures of the section show. */
export const corridor = signal<Filter>(start(COUNT));
