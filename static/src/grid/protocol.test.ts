import { describe, expect, test } from "vitest";
import type { Geometry, Pose } from "../wire/protocol";
import vectors from "../wire/protocol.vectors.json";
import { bresenham } from "./bresenham";
import { logOddsAt } from "./cellValues";
import { cellAt, centreOf, compose, contains } from "./lattice";

describe("the same geometry on both sides", () => {
  test.each(vectors.lattices.map((lattice) => [lattice.origin.join(", "), lattice] as const))(
    "origin %s",
    (_, lattice) => {
      const geometry = { ...lattice, origin: lattice.origin as unknown as Pose } as unknown as Geometry;
      for (const [i, [x, y]] of (lattice.points as [number, number][]).entries()) {
        const cell = cellAt(geometry, x, y);
        expect([cell.row, cell.col]).toEqual(lattice.cells[i]);
        expect(contains(geometry, cell)).toBe(lattice.inside[i]);
        const [cx, cy] = centreOf(geometry, cell);
        expect(cx).toBeCloseTo(lattice.centres[i]?.[0] ?? Number.NaN, 9);
        expect(cy).toBeCloseTo(lattice.centres[i]?.[1] ?? Number.NaN, 9);
      }
    },
  );

  test("poses compose", () => {
    for (const { a, b, c } of vectors.compose) {
      for (const [i, value] of compose(a as unknown as Pose, b as unknown as Pose).entries()) {
        expect(value).toBeCloseTo(c[i] ?? Number.NaN, 12);
      }
    }
  });

  test("a byte means the log-odds that the server quantised, to a step", () => {
    const { quantised } = vectors;
    const step = (quantised.high - quantised.low) / 254 + 1e-6;
    for (const [i, int8] of quantised.int8.entries()) {
      const byte = (int8 & 0xff) ^ 0x80;
      if (!quantised.observed[i]) expect(byte).toBe(0);
      else
        expect(Math.abs(logOddsAt(byte, quantised) - (quantised.log_odds[i] ?? Number.NaN))).toBeLessThanOrEqual(step);
    }
  });

  test("Bresenham's line crosses the same cells in the same order", () => {
    for (const { end, cells } of vectors.lines) {
      const visited: number[][] = [];
      bresenham({ row: 2, col: -1 }, { row: end[0] as number, col: end[1] as number }, (row, col) => {
        visited.push([row, col]);
        return undefined;
      });
      expect(visited).toEqual(cells);
    }
  });
});
