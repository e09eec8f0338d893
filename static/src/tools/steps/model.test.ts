import { expect, test } from "vitest";
import { emptyGrid, INITIAL_CONFIG, indexOf } from "../../grid/occupancyGrid";
import { updatePerBeam } from "../../grid/textbook";
import type { Stepping } from "../../store/sessionSignals";
import type { Store } from "../../store/store";
import type { Frame, Geometry, Pose, Values } from "../../wire/protocol";
import { key, lessonConfig, moved, stepsOfScan, valuesAfterSteps, whyNoSteps } from "./model";
import { valueBeforeSteps } from "./stepping";

const GEOMETRY: Geometry = {
  type: "geometry",
  layer: 1,
  epoch: 1,
  resolution: 0.1,
  rows: 60,
  cols: 60,
  origin: [-3, -3, 0],
  low: -2,
  high: 3.5,
  tile: 64,
};
const POSE: Pose = [0.03, -0.04, 0.4];
const VALUES: Values = { ...INITIAL_CONFIG, model: "fixed_increments", window: 0.2, range_max: 2.5 };

const frame = {
  ranges: Array.from({ length: 40 }, (_, i) => (i % 7 === 3 ? null : 1 + 0.04 * i)),
  angle_min: -Math.PI,
  angle_increment: (2 * Math.PI) / 40,
  range_max: 10,
} as unknown as Frame;

const steppingOf = (values: Values, done?: number, geometry = GEOMETRY): Stepping => {
  const config = lessonConfig(values);
  const steps = stepsOfScan(frame, POSE, geometry, config, values.hit_and_passed === "only_hits");
  return { frame, pose: POSE, geometry, config, steps, index: 1, done: done ?? steps.length };
};

test.each([
  {},
  { no_return: "free" },
  { window: 0 },
  { clamp: false },
  { model: "step_window", p_occ: 0.8, p_free: 0.3 },
])("all steps together are the scan as the textbook's twin has it: %o", (changes) => {
  const stepping = steppingOf({ ...VALUES, ...changes } as Values);
  const grid = emptyGrid(GEOMETRY);
  const ranges = Float32Array.from(frame.ranges, (range) => range ?? Number.POSITIVE_INFINITY);
  const updates = updatePerBeam(grid, { ...frame, ranges, range_min: 0 }, POSE, stepping.config);
  expect(stepping.steps).toHaveLength(updates);
  const held = valuesAfterSteps(stepping, () => 0);
  expect(held.size).toBe(grid.observed.reduce((sum, value) => sum + value, 0));
  for (const { cell } of stepping.steps) {
    expect(held.get(key(cell))).toBeCloseTo(grid.logOdds[indexOf(GEOMETRY, cell)] as number, 6);
  }
});

test("where only the hits count, a scan adds nothing but hits to the cells that it hits", () => {
  const coarse = { ...GEOMETRY, resolution: 0.5, rows: 12, cols: 12 }; // several beams end in a cell, others pass it
  const both = steppingOf(VALUES, 0, coarse).steps;
  const only = steppingOf({ ...VALUES, hit_and_passed: "only_hits" }, 0, coarse).steps;
  const cellsHit = new Set(both.filter((step) => step.isHit).map((step) => key(step.cell)));
  let outweighed = 0;
  both.forEach((step, n) => {
    const counts = step.isHit || !cellsHit.has(key(step.cell));
    expect(only[n]).toEqual(counts ? step : { ...step, evidence: 0 });
    outweighed += counts ? 0 : 1;
  });
  expect(outweighed).toBeGreaterThan(0);
});

test("a reading that is no return is a hit at the max range where the map takes it so", () => {
  const stepping = steppingOf({ ...VALUES, no_return: "hit" });
  const beam = stepping.steps.filter((step) => step.beam === 3);
  expect(beam.some((step) => step.isHit)).toBe(true);
  expect(steppingOf(VALUES).steps.filter((step) => step.beam === 3)).toEqual([]);
});

test("the error term is Bresenham's, and the last cell of a line has none", () => {
  const { steps } = steppingOf({ ...VALUES, window: 0 });
  const beam = steps.filter((step) => step.beam === 11);
  expect(beam.at(-1)).toMatchObject({ nabla: null, isHit: true });
  for (const step of beam.slice(0, -1)) expect(Number.isInteger(step.nabla)).toBe(true);
});

test("on and back by a cell and by a beam", () => {
  const stepping = steppingOf(VALUES, 0);
  expect(moved(stepping, "cell", 1)).toBe(1);
  expect(moved(stepping, "cell", -1)).toBe(0);
  const first = moved(stepping, "beam", 1);
  expect(stepping.steps[first - 1]?.beam).toBe(stepping.steps[0]?.beam);
  expect(stepping.steps[first]?.beam).not.toBe(stepping.steps[0]?.beam);
  expect(moved({ ...stepping, done: first }, "beam", -1)).toBe(0);
  expect(moved({ ...stepping, done: stepping.steps.length }, "cell", 1)).toBe(stepping.steps.length);
});

test("parameters without an order of cells are refused with a reason", () => {
  expect(whyNoSteps(VALUES)).toBeNull();
  for (const change of [{ model: "sonar_cone" }, { update: "per_scan" }, { traversal: "amanatides_woo" }]) {
    expect(whyNoSteps({ ...VALUES, ...change })).toMatch(/^Steps by cell .*\.$/);
  }
});

test("the server's exact value is used if it agrees with the byte", () => {
  const geometry = { epoch: 3, low: -10, high: 10 };
  const value = (byte: number, log_odds: number): number => {
    const store = {
      map: { peek: () => ({ geometry, cells: { at: () => byte } }) },
      inspected: { peek: () => ({ row: 2, col: 5, epoch: 3, log_odds }) },
    } as unknown as Store;
    return valueBeforeSteps(store, { geometry, config: { log_odds_prior: 0 } } as unknown as Stepping, {
      row: 2,
      col: 5,
    });
  };
  expect(value(1, -103.25)).toBe(-103.25); // without a clamp a cell exceeds the range of the bytes
  expect(value(255, 34)).toBe(34);
  expect(value(128, 0.02)).toBe(0.02);
  expect(value(128, -103.25)).toBe(0); // the answer is about another time
  expect(value(0, 1)).toBe(0); // never observed: the prior
});
