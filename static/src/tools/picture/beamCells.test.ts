import { expect, test } from "vitest";
import { INITIAL_CONFIG, type LaserScan } from "../../grid/occupancyGrid";
import { evidenceOfBeam } from "../../grid/textbook";
import type { Geometry, Pose, Values } from "../../wire/protocol";
import { crossed } from "./beamCells";

const GEOMETRY = { resolution: 0.05, rows: 200, cols: 240, origin: [-3, -2, 0] } as unknown as Geometry;
const RANGE_MAX = 6;

/** The evidence of the same beam by the TypeScript version of the textbook: cells and its sign. */
function expected(pose: Pose, bearing: number, range: number | null, values: Values): unknown[] {
  const config = { ...INITIAL_CONFIG, ...values, range_max: RANGE_MAX };
  const scan: LaserScan = {
    ranges: Float32Array.of(range ?? Number.POSITIVE_INFINITY),
    angle_min: bearing,
    angle_increment: 0,
    range_min: 0,
    range_max: RANGE_MAX,
  };
  const found = evidenceOfBeam(GEOMETRY, scan, 0, pose, config);
  return found.map(({ cell, evidence }) => ({ cell, evidence: evidence > 0 ? "hit" : "miss" }));
}

test("a beam's cells and their colours are those of the evidence that they get", () => {
  const values = { window: 0.2, traversal: "bresenham", no_return: "ignore", model: "fixed_increments" };
  for (let i = 0; i < 60; i++) {
    const pose: Pose = [0.013 * i, 1 + 0.007 * i, 0.4 * i];
    const beam = { index: 0, bearing: -1.3 + 0.1 * i, range: Math.fround(0.3 + 0.09 * i) };
    for (const window of [0, 0.2, 0.55])
      for (const traversal of ["bresenham", "amanatides_woo"]) {
        const now = { ...values, window, traversal };
        expect(crossed(GEOMETRY, pose, beam, RANGE_MAX, now)).toEqual(expected(pose, beam.bearing, beam.range, now));
      }
  }
});

test("a beam without return frees its cells, hits at its end or is ignored, as the policy sets", () => {
  const pose: Pose = [0.513, 1.007, 0.4];
  const beam = { index: 0, bearing: 0.1, range: null };
  const evidence = (no_return: string): Set<string> =>
    new Set(crossed(GEOMETRY, pose, beam, RANGE_MAX, { window: 0.2, no_return }).map((cell) => cell.evidence));
  expect(evidence("ignore")).toEqual(new Set(["prior"]));
  expect(evidence("free")).toEqual(new Set(["miss"]));
  expect(evidence("hit")).toEqual(new Set(["miss", "hit"]));
  const freed = crossed(GEOMETRY, pose, beam, RANGE_MAX, { window: 0.2, no_return: "free" });
  expect(freed).toEqual(expected(pose, 0.1, null, { window: 0.2, no_return: "free" }));
});

test("on the smooth ramp a cell turns from free to occupied within the window", () => {
  const beam = { index: 0, bearing: 0, range: 2.01 };
  const values = { model: "smooth_ramp", sigma: 0.1, sigma_growth: 0, log_odds_hit: 0.85, log_odds_miss: -0.4 };
  const cells = crossed(GEOMETRY, [0.025, 0.025, 0], beam, RANGE_MAX, values);
  const hits = cells.filter((cell) => cell.evidence === "hit").map((cell) => cell.cell.col);
  // -0.4 + 1.25 (3t² - 2t³) is above 0 from t = 0.374 on, which is s = 2.01 - 0.2 (1 - 0.374) = 1.885 m.
  expect(hits[0]).toBe(60 + 38);
  expect(cells.at(-1)?.cell.col).toBe(60 + 44);
});
