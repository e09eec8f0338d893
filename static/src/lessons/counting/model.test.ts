import { describe, expect, it } from "vitest";
import { INITIAL_CONFIG } from "../../grid/occupancyGrid";
import { beamsPerCell, distanceOf, expectedBeams, GEOMETRY, mapWith, SENSOR } from "./model";

const near = { row: 11, col: 14 };
const at = (cell: { row: number; col: number }): number => cell.row * GEOMETRY.cols + cell.col;

describe("per beam or per scan", () => {
  it("updates the sensor's own cell with every beam, and a cell in view once per scan", () => {
    const counts = beamsPerCell(180);
    const own = at({ row: Math.floor(SENSOR[1] / 0.1), col: Math.floor(SENSOR[0] / 0.1) });
    expect(counts[own]).toBe(180);
    expect(mapWith("per_beam", 180, 1).logOdds[own]).toBe(INITIAL_CONFIG.log_odds_min);
    expect(mapWith("per_scan", 180, 1).logOdds[at(near)]).toBeCloseTo(INITIAL_CONFIG.log_odds_miss, 6);
  });

  it("counts as many beams as a cell's width covers", () => {
    const counts = beamsPerCell(360);
    const found = counts[at(near)] as number;
    expect(found).toBeGreaterThan(0.6 * expectedBeams(distanceOf(near), 360));
    expect(found).toBeLessThan(1.6 * expectedBeams(distanceOf(near), 360));
  });

  it("makes the per-beam map of twice the beams twice as sure, and leaves the per-scan map as it is", () => {
    const sum = (values: Float32Array): number => values.reduce((a, b) => a + b, 0);
    const counts = [sum(Float32Array.from(beamsPerCell(180))), sum(Float32Array.from(beamsPerCell(360)))];
    expect((counts[1] as number) / (counts[0] as number)).toBeCloseTo(2, 1);
    const [few, many] = [mapWith("per_scan", 180, 1), mapWith("per_scan", 360, 1)];
    const both = [...few.observed.keys()].filter((i) => few.observed[i] === 1 && many.observed[i] === 1);
    const same = both.filter((i) => few.logOdds[i] === many.logOdds[i]);
    expect(same.length / both.length).toBeGreaterThan(0.95);
  });
});
