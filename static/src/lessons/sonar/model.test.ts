import { describe, expect, it } from "vitest";
import { emptyGrid } from "../../grid/occupancyGrid";
import type { Pose } from "../../wire/protocol";
import { noCertainties, type SonarSettings, updateCone, updateMoravecElfes } from "./model";
import vectors from "./sonar.vectors.json";
import { GEOMETRY, POSES, sonarScan } from "./world";

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
    const all = settings as SonarSettings;
    const certain = noCertainties(LATTICE);
    const grid = model === "moravec_elfes" ? certain.grid : emptyGrid(LATTICE);
    vectors.poses.forEach((pose, i) => {
      if (model === "moravec_elfes") updateMoravecElfes(certain, scanOf(i), pose as unknown as Pose, all);
      else updateCone(grid, scanOf(i), pose as unknown as Pose, all);
    });
    const seen = [...grid.observed.keys()].filter((index) => grid.observed[index] === 1);
    expect(seen).toEqual(cells.map(([index]) => index));
    for (const [index, value] of cells) expect(grid.logOdds[index as number]).toBeCloseTo(value as number, 4);
    statistics.forEach(([occupied, empty], k) => {
      expect(certain.occupied[seen[k] as number]).toBeCloseTo(occupied as number, 5);
      expect(certain.empty[seen[k] as number]).toBeCloseTo(empty as number, 5);
    });
  });

  it("measure the nearest surface in the cone, not the one on its axis", () => {
    const pose: Pose = [1, 1, 0];
    expect(sonarScan(pose, 0.5).ranges[12]).toBeCloseTo(0.6, 5); // straight down to the wall
    // Ahead the door is open; the nearest surface in the cone is where its edge meets the upper wall.
    expect(sonarScan([1, 2.7, 0], 0.5).ranges[0]).toBeCloseTo(0.3 / Math.sin(0.25), 5);
  });

  it("only ever grow in certainty, as Moravec and Elfes combine them", () => {
    const map = noCertainties(GEOMETRY);
    const settings: SonarSettings = { opening: 0.5236, window: 0.2, profile: "flat", no_return: "ignore" };
    let [occupied, empty] = [map.occupied.slice(), map.empty.slice()];
    for (const pose of POSES.slice(0, 3)) {
      updateMoravecElfes(map, sonarScan(pose, settings.opening), pose, settings);
      expect(map.occupied.every((value, i) => value >= (occupied[i] ?? 0))).toBe(true);
      expect(map.empty.every((value, i) => value >= (empty[i] ?? 0))).toBe(true);
      [occupied, empty] = [map.occupied.slice(), map.empty.slice()];
    }
  });
});
