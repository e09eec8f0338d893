import { describe, expect, it } from "vitest";
import { cellsOf, phantoms } from "../common/counts";
import { CORRECT, mapWith, WALLS } from "./model";

const smear = (correction: typeof CORRECT): number => phantoms(mapWith(correction), WALLS, 0.2).length;

describe("a mount", () => {
  it("that is right puts walls where walls are", () => {
    expect(smear(CORRECT)).toBe(0);
    expect(cellsOf(mapWith(CORRECT), "occupied").length).toBeGreaterThan(120);
  });

  it("that is wrong puts them elsewhere, each way of being wrong", () => {
    expect(smear({ ...CORRECT, yaw: 0.1 })).toBeGreaterThan(15);
    expect(smear({ ...CORRECT, y: 0.4 })).toBeGreaterThan(15);
    expect(smear({ ...CORRECT, upsideDown: true })).toBeGreaterThan(50);
  });

  it("that is wrong smears walls when the robot turns, and more with a larger error", () => {
    const angles = [0, 0.05, 0.1, 0.2].map((yaw) => smear({ ...CORRECT, yaw }));
    expect(angles).toEqual([...angles].sort((a, b) => a - b));
  });
});
