import { describe, expect, it } from "vitest";
import { bresenham, bresenhamSteps, octant } from "./bresenham";
import type { Cell } from "./lattice";

const BOTH = { direction: true, steep: true };

describe("Bresenham's line in steps", () => {
  it("is the line of the map, in every direction", () => {
    for (let row = -7; row <= 7; row++)
      for (let col = -7; col <= 7; col++) {
        const cells: Cell[] = [];
        bresenham({ row: 2, col: 3 }, { row, col }, (r, c) => {
          cells.push({ row: r, col: c });
          return true;
        });
        expect(bresenhamSteps({ row: 2, col: 3 }, { row, col }, BOTH).steps.map((step) => step.cell)).toEqual(cells);
      }
  });

  it("keeps ∇ = 2·(error of going straight) in whole numbers: its sign is that of the line's side", () => {
    const line = bresenhamSteps({ row: 0, col: 0 }, { row: 3, col: 8 }, BOTH);
    for (const { cell, nabla } of line.steps) {
      if (nabla === null) continue;
      // Where the true line is at the next column, above the middle between the two candidates.
      const above = ((cell.col + 1) * 3) / 8 - (cell.row + 0.5);
      expect(nabla).toBeCloseTo(2 * 8 * above, 9);
    }
  });

  it("needs both fixes outside the first octant", () => {
    const last = (end: Cell, fixes = BOTH): Cell | undefined =>
      bresenhamSteps({ row: 0, col: 0 }, end, fixes).steps.at(-1)?.cell;
    for (const end of [
      { row: 3, col: 8 },
      { row: 8, col: 3 },
      { row: -3, col: -8 },
    ])
      expect(last(end)).toEqual(end);
    expect(last({ row: 3, col: 8 }, { direction: false, steep: false })).toEqual({ row: 3, col: 8 });
    expect(last({ row: 8, col: 3 }, { direction: true, steep: false })).toEqual({ row: 3, col: 3 });
    expect(last({ row: 3, col: -8 }, { direction: false, steep: true })).not.toEqual({ row: 3, col: -8 });
    expect(last({ row: 0, col: -8 }, { direction: false, steep: false })).toEqual({ row: 0, col: 0 });
  });

  it("names the octants counter-clockwise from east", () => {
    const from = { row: 0, col: 0 };
    expect(octant(from, { row: 1, col: 3 })).toBe(1);
    expect(octant(from, { row: 3, col: 1 })).toBe(2);
    expect(octant(from, { row: 3, col: -1 })).toBe(3);
    expect(octant(from, { row: -1, col: 3 })).toBe(8);
    expect(octant(from, { row: -3, col: -1 })).toBe(6);
  });
});
