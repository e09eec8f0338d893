/**
 * The program run line by line: which line is about to run, and the values at that time. The sequence of lines is
 * tested against a trace of the lines that Python executes (program.vectors.json).
 */

import type { Cell } from "../../grid/lattice";
import {
  emptyGrid,
  type GridGeometry,
  INITIAL_CONFIG,
  indexOf,
  type LaserScan,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import { bayesFilter, type Evidence, evidenceOfBeam, update } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { type FunctionName, lineOf } from "./source";

export interface Step {
  readonly fn: FunctionName;
  /** The line that is about to run, counted from its function's `def`. */
  readonly offset: number;
  /** The current beam; null before the first and after the last. */
  readonly beam: number | null;
  /** The evidence of the beam, as far as it has been computed. */
  readonly evidence: readonly Evidence[];
  /** Index of the evidence that is being added to its cell; null while it is computed. */
  readonly current: number | null;
  /** How many updates have been made before this line runs. */
  readonly done: number;
}

export interface Change {
  readonly cell: Cell;
  readonly evidence: number;
  readonly before: number;
  readonly after: number;
}

export interface Run {
  readonly geometry: GridGeometry;
  readonly steps: readonly Step[];
  readonly changes: readonly Change[];
}

type Where = readonly [fn: FunctionName, beginning: string];

const START: readonly Where[] = [
  ["update_per_beam", "z_max ="],
  ["update_per_beam", "updates = 0"],
];
const NEXT_BEAM: Where = ["update_per_beam", "for z, bearing"];
const GATHER: readonly Where[] = [
  ["update_per_beam", "evidence = evidence_of_beam"],
  ["evidence_of_beam", "is_cone ="],
  ["evidence_of_beam", "if z_min <= z <= z_max"],
];
const NOTHING: readonly Where[] = [
  ["evidence_of_beam", "if z > z_max and"],
  ["evidence_of_beam", "return {}"],
];
const READING: readonly Where[] = [
  ["evidence_of_beam", "if is_cone"],
  ["evidence_of_beam", "return evidence_along_beam"],
  ["evidence_along_beam", "model ="],
  ["evidence_along_beam", "half ="],
  ["evidence_along_beam", "endpoint ="],
  ["evidence_along_beam", "if half == 0.0"],
  ["evidence_along_beam", "evidence = dict.fromkeys"],
];
const ENDPOINT: Where = ["evidence_along_beam", "evidence[endpoint]"];
const GATHERED: Where = ["evidence_along_beam", "return evidence"];
const PUT: Where = ["update_per_beam", "updates += sum"];
const IS_INSIDE: Where = ["update", "if not grid.geometry.contains"];
const IS_OUTSIDE: Where = ["update", "return 0"];
const CHANGE: readonly Where[] = [
  ["update", "grid.log_odds[cell] ="],
  ["bayes_filter", "low, high ="],
  ["bayes_filter", "return min"],
];
const CHANGED: readonly Where[] = [
  ["update", "grid.observed[cell]"],
  ["update", "return 1"],
];
const END: Where = ["update_per_beam", "return updates"];

/** Run `update_per_beam` on an empty grid with the mapper's first settings; no returns are ignored, r is 0. */
export function runProgram(geometry: GridGeometry, scan: LaserScan, pose: Pose): Run {
  const grid = emptyGrid(geometry);
  const steps: Step[] = [];
  const changes: Change[] = [];
  let beam: number | null = null;
  let evidence: readonly Evidence[] = [];
  let current: number | null = null;
  const at = (...wheres: readonly Where[]): void => {
    for (const [fn, beginning] of wheres)
      steps.push({ fn, offset: lineOf(fn, beginning), beam, evidence, current, done: changes.length });
  };

  at(...START);
  for (let i = 0; i < scan.ranges.length; i++) {
    at(NEXT_BEAM);
    beam = i;
    evidence = [];
    current = null;
    at(...GATHER);
    const updates = evidenceOfBeam(geometry, scan, i, pose, INITIAL_CONFIG);
    if (updates.length === 0) at(...NOTHING);
    else {
      at(...READING);
      evidence = updates.map(({ cell }) => ({ cell, evidence: INITIAL_CONFIG.log_odds_miss }));
      at(ENDPOINT);
      evidence = updates;
      at(GATHERED);
    }
    at(PUT);
    for (const [k, entry] of updates.entries()) {
      current = k;
      at(IS_INSIDE);
      const index = indexOf(geometry, entry.cell);
      if (index < 0) {
        at(IS_OUTSIDE);
        continue;
      }
      at(...CHANGE);
      const before = grid.logOdds[index] ?? 0;
      update(grid, entry.cell, entry.evidence, INITIAL_CONFIG);
      changes.push({ ...entry, before, after: bayesFilter(before, entry.evidence, INITIAL_CONFIG) });
      at(...CHANGED);
    }
    current = null;
  }
  at(NEXT_BEAM);
  beam = null;
  evidence = [];
  at(END);
  return { geometry, steps, changes };
}

/** The grid before a step runs: the updates that were made until then. */
export function gridBefore(run: Run, step: number): OccupancyGrid {
  const grid = emptyGrid(run.geometry);
  for (const { cell, evidence } of run.changes.slice(0, run.steps[step]?.done ?? 0))
    update(grid, cell, evidence, INITIAL_CONFIG);
  return grid;
}

export type StepSize = "line" | "cell" | "beam" | "scan";

/** The step that is a line, a cell, a beam or the scan after step `from`, or before it. */
export function stepFrom(run: Run, from: number, by: StepSize, direction: 1 | -1): number {
  const last = run.steps.length - 1;
  const inside = (step: number): number => Math.min(last, Math.max(0, step));
  if (by === "line") return inside(from + direction);
  if (by === "scan") return direction === 1 ? last : 0;
  const isStop = (step: number): boolean => {
    const [here, before] = [run.steps[step], run.steps[step - 1]];
    if (!here || !before) return true;
    return by === "beam" ? here.beam !== before.beam : here.current !== null && here.current !== before.current;
  };
  let step = inside(from + direction);
  while (step > 0 && step < last && !isStop(step)) step += direction;
  return step;
}
