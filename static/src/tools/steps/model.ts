/**
 * One scan, cell by cell: every update that the mapper makes with it, in the same order, as in `update_per_beam` in
 * `mapper/mapping/textbook.py` with Bresenham's line. Only for models that add log-odds along thin beams.
 */

import { bresenhamSteps } from "../../grid/bresenham";
import type { Cell } from "../../grid/lattice";
import { INITIAL_CONFIG, type MappingConfig } from "../../grid/occupancyGrid";
import { beamModel, INITIAL_PARAMETERS, type SensorModelParameters } from "../../grid/sensorModel";
import { bayesFilter, cellsAlong, evidenceOfBeam } from "../../grid/textbook";
import type { Step, Stepping } from "../../store/sessionSignals";
import type { Frame, Geometry, Pose, Values } from "../../wire/protocol";

/** Why steps by cell and beam are not possible; null if they are. */
export function whyNoSteps(values: Values): string | null {
  if (values.model !== "fixed_increments" && values.model !== "step_window") {
    return "Steps by cell and beam need thin beams: choose the model “fixed increments” or “step window in probabilities”.";
  }
  if (values.update !== "per_beam")
    return "Steps by cell and beam need the update per beam: with the update per scan the beams have no order.";
  if (values.traversal !== "bresenham")
    return "Steps by cell and beam follow Bresenham’s line: choose Bresenham as the traversal.";
  return null;
}

/** The parameters for the TypeScript version of the textbook; a step window as its two increments. */
export function lessonConfig(values: Values): MappingConfig {
  const config = { ...INITIAL_CONFIG, ...values } as unknown as MappingConfig;
  const model = beamModel({ ...INITIAL_PARAMETERS, ...(values as Partial<SensorModelParameters>) });
  return { ...config, log_odds_hit: model.hit, log_odds_miss: model.miss };
}

/**
 * Every update of one scan, in order of the beams. With `onlyHits` the misses of cells that the scan hits are 0, as in
 * `hits_before_misses` in `mapper/mapping/textbook.py`; the order of zeros does not matter.
 */
export function stepsOfScan(
  frame: Frame,
  pose: Pose,
  geometry: Geometry,
  config: MappingConfig,
  onlyHits: boolean,
): readonly Step[] {
  const greatest = Math.min(frame.range_max, config.range_max);
  // A no return that counts as a hit is a reading of the max range; null means no return on the wire.
  const none = config.no_return === "hit" ? greatest : Number.POSITIVE_INFINITY;
  const ranges = Float32Array.from(frame.ranges, (range) => (range === null || range > greatest ? none : range));
  const scan = { ...frame, ranges, range_min: 0, range_max: frame.range_max };
  const steps: Step[] = [];
  ranges.forEach((range, beam) => {
    const updates = evidenceOfBeam(geometry, scan, beam, pose, config);
    if (updates.length === 0) return;
    const reach = range <= greatest ? range + config.window / 2 : greatest;
    const bearing = frame.angle_min + beam * frame.angle_increment;
    const cells = cellsAlong(geometry, pose, bearing, reach, config);
    const line = bresenhamSteps(cells[0] as Cell, cells.at(-1) as Cell, { direction: true, steep: true });
    const terms = new Map(line.steps.map(({ cell, nabla }) => [key(cell), nabla]));
    updates.forEach(({ cell, evidence }, place) => {
      const isHit = evidence === config.log_odds_hit && evidence > 0;
      steps.push({ beam, place, of: updates.length, cell, evidence, isHit, nabla: terms.get(key(cell)) ?? null });
    });
  });
  if (!onlyHits) return steps;
  const hits = (step: Step): boolean => step.evidence === config.log_odds_hit;
  const cellsHit = new Set(steps.filter(hits).map(({ cell }) => key(cell)));
  return steps.map((step) => (hits(step) || !cellsHit.has(key(step.cell)) ? step : { ...step, evidence: 0 }));
}

export const key = ({ row, col }: Cell): string => `${row} ${col}`;

/** The log-odds of each cell that the first `done` steps updated; `before` gives its value before the first step. */
export function valuesAfterSteps(stepping: Stepping, before: (cell: Cell) => number): ReadonlyMap<string, number> {
  const held = new Map<string, number>();
  for (let n = 0; n < stepping.done; n++) {
    const { cell, evidence } = stepping.steps[n] as Step;
    const name = key(cell);
    held.set(name, bayesFilter(held.get(name) ?? before(cell), evidence, stepping.config));
  }
  return held;
}

/** The number of steps done after moving forward or back by a cell or by a beam. */
export function moved(stepping: Stepping, unit: "cell" | "beam", by: 1 | -1): number {
  const { steps, done } = stepping;
  if (unit === "cell") return Math.min(steps.length, Math.max(0, done + by));
  if (by === 1) {
    const beam = steps[done]?.beam;
    let n = done;
    while (n < steps.length && steps[n]?.beam === beam) n++;
    return n;
  }
  const beam = steps[done - 1]?.beam;
  let n = done;
  while (n > 0 && steps[n - 1]?.beam === beam) n--;
  return n;
}
