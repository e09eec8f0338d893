import { describe, expect, it } from "vitest";
import type { GridGeometry } from "../../grid/occupancyGrid";
import { combine, inflate } from "./costmap";
import vectors from "./navigation.vectors.json";
import { type Ground, pathBack, search, stepCosts } from "./planner";

const { rows, cols, resolution } = vectors;
const geometry: GridGeometry = { rows, cols, resolution, origin: [0, 0, 0] };

describe("the costmap of the lecture", () => {
  it("is inflated as by the library", () => {
    for (const { costs, inscribed, radius, factor, inflated } of vectors.inflations) {
      const inflation = { inflation_radius: radius, cost_scaling_factor: factor };
      expect([...inflate(Uint8Array.from(costs), geometry, inscribed, inflation)]).toEqual(inflated);
    }
  });

  it("is combined as by the library", () => {
    const { master, layer, combined } = vectors.combination;
    expect([...combine(Uint8Array.from(master), Uint8Array.from(layer))]).toEqual(combined);
  });
});

describe("the planner of the lecture", () => {
  it("finds the potentials and paths of the library", () => {
    for (const { costs, unknown, a_star, start, goal, potential, path } of vectors.searches) {
      const ground: Ground = { costs: Uint8Array.from(costs), rows, cols, table: stepCosts(unknown) };
      const result = search(ground, start, goal, a_star);
      result.potential.forEach((cost, i) => {
        expect(Number.isFinite(cost) ? cost : -1).toBeCloseTo(potential[i] ?? Number.NaN, 5);
      });
      expect(pathBack(ground, result.potential, start, goal) ?? []).toEqual(path);
    }
  });

  it("expands fewer cells with A*, for a path of the same cost", () => {
    const costs = new Uint8Array(40 * 40);
    const ground: Ground = { costs, rows: 40, cols: 40, table: stepCosts(true) };
    const [start, goal] = [10 * 40 + 5, 30 * 40 + 35];
    const [wave, directed] = [search(ground, start, goal, false), search(ground, start, goal, true)];
    expect(directed.potential[goal]).toBeCloseTo(wave.potential[goal] ?? 0, 6);
    expect(directed.order.length).toBeLessThan(0.6 * wave.order.length);
  });
});
