import { describe, expect, it } from "vitest";
import { emptyStatistics } from "../../grid/occupancyGrid";
import type { Pose } from "../../wire/protocol";
import { coneModel, type SonarSettings, updateWide } from "./model";
import vectors from "./sonar.vectors.json";
import { GEOMETRY, POSES, RANGE_MAX, sonarScan } from "./world";

const LATTICE = { ...vectors.geometry, origin: vectors.geometry.origin as unknown as Pose };
const scanOf = (i: number) => ({
  ranges: Float32Array.from(vectors.scans[i] ?? [], (value) =>
    value === "inf" ? Number.POSITIVE_INFINITY : Number(value),
  ),
  bearings: vectors.bearings,
  range_min: 0.05,
  range_max: 2.5,
});

describe("wide beams", () => {
  it.each(vectors.maps)("make the mapper's map: $model, $settings", ({ model, settings, cells, statistics }) => {
    const values = coneModel(model as "sonar_cone" | "moravec_elfes", settings as SonarSettings, 2.5);
    const grid = emptyStatistics(LATTICE);
    vectors.poses.forEach((pose, i) => {
      updateWide(grid, scanOf(i), pose as unknown as Pose, values);
    });
    const seen = [...grid.observed.keys()].filter((index) => grid.observed[index] === 1);
    expect(seen).toEqual(cells.map(([index]) => index));
    for (const [index, value] of cells) expect(grid.logOdds[index as number]).toBeCloseTo(value as number, 4);
    statistics.forEach(([occupied, empty], k) => {
      expect(grid.statistics[0][seen[k] as number]).toBeCloseTo(occupied as number, 5);
      expect(grid.statistics[1][seen[k] as number]).toBeCloseTo(empty as number, 5);
    });
  });

  it("measure the nearest surface in the cone, not the one on its axis", () => {
    const pose: Pose = [1, 1, 0];
    expect(sonarScan(pose, 0.5).ranges[12]).toBeCloseTo(0.6, 5); // straight down to the wall
    // Ahead the door is open; the nearest surface in the cone is where its edge meets the upper wall.
    expect(sonarScan([1, 2.7, 0], 0.5).ranges[0]).toBeCloseTo(0.3 / Math.sin(0.25), 5);
  });

  it("only ever grow in certainty, as Moravec and Elfes combine them", () => {
    const grid = emptyStatistics(GEOMETRY);
    const settings: SonarSettings = { opening: 0.5236, window: 0.2, profile: "flat", no_return: "ignore" };
    let before = grid.statistics.map((certainties) => certainties.slice());
    for (const pose of POSES.slice(0, 3)) {
      updateWide(grid, sonarScan(pose, 0.5236), pose, coneModel("moravec_elfes", settings, RANGE_MAX));
      grid.statistics.forEach((certainties, k) => {
        expect(certainties.every((value, i) => value >= (before[k]?.[i] ?? 0))).toBe(true);
      });
      before = grid.statistics.map((certainties) => certainties.slice());
    }
  });
});
