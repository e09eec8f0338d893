import { describe, expect, it } from "vitest";
import type { Point } from "../../wire/protocol";
import { cellsOf, phantoms, stateOf } from "../common/counts";
import { GEOMETRY, GLASS, mapAt, scanAt, WALLS } from "./model";

const HERE: Point = [2.4, 3];
const at = (x: number, y: number): number => Math.floor(y / 0.2) * GEOMETRY.cols + Math.floor(x / 0.2);

describe("beams without return", () => {
  it("are those into the glass and beyond the range, and no others", () => {
    const { ranges } = scanAt([2.4, 1.3], 3);
    expect(ranges[0]).toBe(Number.POSITIVE_INFINITY); // straight into the pane
    expect(ranges[90]).toBeCloseTo(1.9, 5); // the wall behind
    expect(scanAt(HERE, 3).ranges[0]).toBe(Number.POSITIVE_INFINITY); // 6.7 m to the far wall
  });

  it("free more cells when counted as free, and add a ring of walls when counted as hits", () => {
    const [ignored, freed, wrong] = (["ignore", "free", "hit"] as const).map((policy) => mapAt(HERE, 3, policy));
    if (!ignored || !freed || !wrong) throw new Error("three maps");
    expect(cellsOf(freed, "free").length).toBeGreaterThan(cellsOf(ignored, "free").length + 20);
    expect(phantoms(ignored, [...WALLS, ...GLASS], 0.25)).toHaveLength(0);
    expect(phantoms(freed, [...WALLS, ...GLASS], 0.25)).toHaveLength(0);
    expect(phantoms(wrong, [...WALLS, ...GLASS], 0.25).length).toBeGreaterThan(10);
  });

  it("free the cells of the glass when no return is counted as free", () => {
    expect(stateOf(mapAt([2.4, 1.3], 3, "free"), at(3.9, 1.3))).toBe("free");
    expect(stateOf(mapAt([2.4, 1.3], 3, "ignore"), at(3.9, 1.3))).toBe("unknown");
  });
});
