import { describe, expect, it } from "vitest";
import { costAt, factorFor } from "../../grid/costs";
import vectors from "../../grid/costs.vectors.json";
import { byteOfCost, costOfByte } from "../../render/map/costColours";
import { crossingOf, OUTLINES } from "./footprint";
import { cellOn, draggedGaps, LEAST_GAP, paintOrder, placeOn, sheetPlan } from "./sheetPlan";

describe("the cost of a distance", () => {
  it("is that of the server", () => {
    for (const { distance, inscribed, factor, cost } of vectors)
      expect(costAt(distance, inscribed, { inflation_radius: 9, cost_scaling_factor: factor })).toBe(cost);
  });
  it("is 0 beyond the inflation radius", () => {
    expect(costAt(0.56, 0.2, { inflation_radius: 0.55, cost_scaling_factor: 1 })).toBe(0);
  });
  it("leads back to the factor of a dragged point", () => {
    const cost = 252 * Math.exp(-3 * 0.2);
    expect(factorFor(cost, 0.4, 0.2)).toBeCloseTo(3, 6);
  });
  it("has a byte in a grid, and back", () => {
    for (const cost of [0, 1, 252, 253, 254, 255]) expect(costOfByte(byteOfCost(cost))).toBe(cost);
    expect(byteOfCost(255)).toBe(0);
  });
});

describe("the outline of the robot", () => {
  it("has no note for those to begin with", () => {
    for (const { corners } of OUTLINES) expect(crossingOf(corners)).toBeNull();
  });
  it("has a note where it crosses itself, as Nav2 takes it", () => {
    const crossed = [
      [0.3, 0.3],
      [-0.3, -0.3],
      [-0.3, 0.3],
      [0.3, -0.3],
    ] as const;
    expect(crossingOf(crossed)).toContain("corner 1 and from corner 3");
  });
  it("may lie beside the centre, as in Nav2", () => {
    const beside = [
      [0.1, 0.1],
      [0.3, 0.1],
      [0.2, 0.3],
    ] as const;
    expect(crossingOf(beside)).toBeNull();
  });
});

describe("the sheets", () => {
  it("are painted from the bottom up, the one in front last", () => {
    expect(paintOrder(4, null)).toEqual([0, 1, 2, 3]);
    expect(paintOrder(4, 1)).toEqual([0, 2, 3, 1]);
  });
  const plan = sheetPlan({ row0: 10, rows: 40, col0: 20, cols: 80 }, 400, 300, [50, 50]);
  it("find the cell that they show at a place, topmost first", () => {
    plan.corners.forEach((corner, sheet) => {
      const [x, y] = placeOn(plan, corner, 97.5, 49.5);
      const hit = cellOn(plan, x, y);
      expect(hit?.cell).toEqual(hit?.sheet === sheet ? { row: 49, col: 97 } : hit?.cell);
    });
    const top = plan.corners.at(-1);
    expect(top && cellOn(plan, ...placeOn(plan, top, 20.5, 10.5))).toEqual({ sheet: 2, cell: { row: 10, col: 20 } });
    expect(cellOn(plan, 1, 1)).toBeNull();
  });
  it("lie within the picture", () => {
    const top = plan.corners.at(-1);
    expect(top && placeOn(plan, top, 20, 50)[1]).toBeGreaterThanOrEqual(0);
    expect(placeOn(plan, plan.corners[0] ?? [0, 0], 100, 50)[0]).toBeLessThanOrEqual(400);
  });
  it("are pulled apart within what there is room for", () => {
    expect(draggedGaps([50, 50], 1, 30, 200)).toEqual([80, 50]);
    expect(draggedGaps([50, 50], 2, 500, 200)).toEqual([50, 150]);
    expect(draggedGaps([50, 50], 2, -500, 200)).toEqual([50, LEAST_GAP]);
  });
});
