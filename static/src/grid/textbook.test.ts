import { describe, expect, it } from "vitest";
import type { Point, Pose } from "../wire/protocol";
import { bresenham } from "./bresenham";
import { emptyStatistics, type GridGeometry, INITIAL_CONFIG, type MappingConfig } from "./occupancyGrid";
import { beamModel, cellIncrement, INITIAL_PARAMETERS } from "./sensorModel";
import { amanatidesWoo, evidenceOfBeam, occupancyGridMapping } from "./textbook";
import vectors from "./textbook.vectors.json";

const GEOMETRY: GridGeometry = { ...vectors.geometry, origin: vectors.geometry.origin as unknown as Pose };
const reading = (value: string | number): number => (value === "inf" ? Number.POSITIVE_INFINITY : Number(value));

describe("the lecture's textbook", () => {
  it("has the smooth ramp's evidence in the window, as the curve of the mapper's model", () => {
    const geometry = { resolution: 0.1, cols: 60, rows: 1, origin: [0, 0, 0] } as const;
    const z = 3.03;
    const scan = { angle_min: 0, angle_increment: 0.1, range_min: 0, range_max: 10, ranges: Float32Array.of(z) };
    const values = {
      ...INITIAL_PARAMETERS,
      model: "smooth_ramp",
      sigma: 0.1,
      sigma_growth: 0.02,
      resolution: 0.1,
    } as const;
    const { hit, miss } = beamModel(values);
    const config = { ...INITIAL_CONFIG, ramp: { sigma: 0.1, growth: 0.02 }, log_odds_hit: hit, log_odds_miss: miss };
    const found = evidenceOfBeam(geometry, scan, 0, [0, 0.05, 0], config);
    expect(found.map(({ cell }) => cell.col)).toEqual(Array.from({ length: 34 }, (_, col) => col));
    for (const { cell, evidence } of found) expect(evidence).toBeCloseTo(cellIncrement(cell.col, z, values), 6);
  });

  it("begins with the mapper's first values", () => {
    expect(INITIAL_CONFIG).toEqual(vectors.initial);
  });

  it.each(vectors.lines)("steps to $end as the mapper does", (line) => {
    const end = line.end as unknown as Point;
    const found: number[][] = [];
    bresenham({ row: 0, col: 0 }, { row: Math.floor(end[1]), col: Math.floor(end[0]) }, (row, col) => {
      found.push([row, col]);
      return true;
    });
    expect(found).toEqual(line.bresenham);
    expect(amanatidesWoo([0.3, 0.6], end).map(({ row, col }) => [row, col])).toEqual(line.amanatides_woo);
  });

  it.each(vectors.maps)("makes the mapper's map with $config", ({ config, cells }) => {
    const settings = { ...INITIAL_CONFIG, ...config } as MappingConfig;
    const grid = emptyStatistics(GEOMETRY, settings.log_odds_prior);
    vectors.poses.forEach((pose, i) => {
      const scan = {
        ranges: Float32Array.from(vectors.scans[i] ?? [], reading),
        angle_min: 0.05,
        angle_increment: (2 * Math.PI) / 24,
        range_min: 0.05,
        range_max: 5,
      };
      occupancyGridMapping(grid, scan, pose as unknown as Pose, settings);
    });
    const seen = [...grid.observed.keys()].filter((index) => grid.observed[index] === 1);
    expect(seen).toEqual(cells.map(([index]) => index));
    for (const [index, value] of cells) expect(grid.logOdds[index as number]).toBeCloseTo(value as number, 5);
  });
});
