/**
 * One scan, cell by cell: every update that the core makes of it, in its order, as `mapper/mapping/textbook.py` has it
 * (update_per_beam on Bresenham's line). Only for what is a sum along thin beams; the other ways have no such order.
 */

import { bresenhamSteps } from "../../grid/bresenhamSteps";
import type { Cell } from "../../grid/lattice";
import { INITIAL_CONFIG, type MappingConfig } from "../../grid/occupancyGrid";
import { beamModel, INITIAL_PARAMETERS, type SensorModelParameters } from "../../grid/sensorModel";
import { bayesFilter, cellsAlong, evidenceOfBeam } from "../../grid/textbook";
import type { Step, Walk } from "../../store/walk";
import type { Frame, Geometry, Pose, Values } from "../../wire/protocol";

/** Why the scan cannot be shown cell by cell; null where it can. */
export function whyNoSteps(values: Values): string | null {
  if (values.model !== "fixed_increments" && values.model !== "step_window") {
    return "Cell by cell is for the thin beams of fixed increments and the step window; choose one of these models.";
  }
  if (values.update !== "per_beam")
    return "Cell by cell is for the update per beam: per scan there is no order of beams.";
  if (values.traversal !== "bresenham") return "Cell by cell follows Bresenham's line; choose it as the traversal.";
  return null;
}

/** The parameters as the twin of the textbook takes them: a step window as the increments that it comes to. */
export function lessonConfig(values: Values): MappingConfig {
  const config = { ...INITIAL_CONFIG, ...values } as unknown as MappingConfig;
  const model = beamModel({ ...INITIAL_PARAMETERS, ...(values as Partial<SensorModelParameters>) });
  return { ...config, log_odds_hit: model.hit, log_odds_miss: model.miss };
}

/** Every update of one scan, in order. */
export function stepsOfScan(frame: Frame, pose: Pose, geometry: Geometry, config: MappingConfig): readonly Step[] {
  const greatest = Math.min(frame.range_max, config.range_max);
  // Where no return is taken for a hit it comes from the max range; null is no return on the wire.
  const none = config.no_return === "hit" ? greatest : Number.POSITIVE_INFINITY;
  const ranges = Float32Array.from(frame.ranges, (range) => (range === null || range > greatest ? none : range));
  const scan = { ...frame, ranges, range_min: 0, range_max: frame.range_max };
  const steps: Step[] = [];
  ranges.forEach((range, beam) => {
    const found = evidenceOfBeam(geometry, scan, beam, pose, config);
    if (found.length === 0) return;
    const reach = range <= greatest ? range + config.window / 2 : greatest;
    const bearing = frame.angle_min + beam * frame.angle_increment;
    const cells = cellsAlong(geometry, pose, bearing, reach, config);
    const line = bresenhamSteps(cells[0] as Cell, cells.at(-1) as Cell, { direction: true, steep: true });
    const terms = new Map(line.steps.map(({ cell, nabla }) => [key(cell), nabla]));
    found.forEach(({ cell, evidence }, place) => {
      const isHit = evidence === config.log_odds_hit && evidence > 0;
      steps.push({ beam, place, of: found.length, cell, evidence, isHit, nabla: terms.get(key(cell)) ?? null });
    });
  });
  return steps;
}

export const key = ({ row, col }: Cell): string => `${row} ${col}`;

/** The log-odds of each cell that the first `done` steps touched, from what the map held `before`. */
export function valuesAfterSteps(walk: Walk, before: (cell: Cell) => number): ReadonlyMap<string, number> {
  const held = new Map<string, number>();
  for (let n = 0; n < walk.done; n++) {
    const { cell, evidence } = walk.steps[n] as Step;
    const name = key(cell);
    held.set(name, bayesFilter(held.get(name) ?? before(cell), evidence, walk.config));
  }
  return held;
}

/** How many steps are done after going on, or back, by a cell or by a beam. */
export function moved(walk: Walk, unit: "cell" | "beam", by: 1 | -1): number {
  const { steps, done } = walk;
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
