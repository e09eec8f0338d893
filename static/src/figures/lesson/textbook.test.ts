import { describe, expect, it } from "vitest";
import { amanatidesWoo } from "../../amanatidesWoo";
import { bresenham } from "../../bresenham";
import type { Point, Pose } from "../../protocol";
import { CONFIG, emptyGrid, type LessonConfig, type LessonGeometry } from "./grid";
import vectors from "./lesson.vectors.json";
import { occupancyGridMapping } from "./textbook";
import { allRound, box, castRay, scanFrom } from "./world";

const GEOMETRY: LessonGeometry = { ...vectors.geometry, origin: vectors.geometry.origin as unknown as Pose };
const reading = (value: string | number): number => (value === "inf" ? Number.POSITIVE_INFINITY : Number(value));

describe("the lecture's textbook", () => {
  it("begins with the mapper's first values", () => {
    expect(CONFIG).toEqual(vectors.initial);
  });

  it.each(vectors.lines)("walks to $end as the mapper does", (line) => {
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
    const settings = { ...CONFIG, ...config } as LessonConfig;
    const grid = emptyGrid(GEOMETRY, settings.log_odds_prior);
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

describe("the lecture's world", () => {
  it("measures the distance to the nearest wall", () => {
    const room = box(0, 0, 4, 3);
    expect(castRay(room, 1, 1, 0)).toBeCloseTo(3, 12);
    expect(castRay(room, 1, 1, Math.PI / 2)).toBeCloseTo(2, 12);
    expect(castRay(room, 1, 1, Math.PI / 4)).toBeCloseTo(2 * Math.SQRT2, 12);
    expect(castRay([...room, [2, 0, 2, 2]], 1, 1, 0)).toBeCloseTo(1, 12);
    expect(castRay([[2, 0, 2, 2]], 1, 1, Math.PI)).toBe(Number.POSITIVE_INFINITY);
  });

  it("reports no return beyond the lidar's range", () => {
    const scan = scanFrom(box(0, 0, 4, 3), [1, 1, 0], allRound(4, 2.5));
    expect([...scan.ranges]).toEqual([Number.POSITIVE_INFINITY, 2, 1, 1].map(Math.fround));
  });
});
