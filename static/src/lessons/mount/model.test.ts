import { describe, expect, it } from "vitest";
import { cellsOf, phantoms } from "../common/counts";
import { mapWith, RIGHT, WALLS } from "./model";

const smear = (correction: typeof RIGHT): number => phantoms(mapWith(correction), WALLS, 0.2).length;

describe("a mount", () => {
  it("that is right puts walls where walls are", () => {
    expect(smear(RIGHT)).toBe(0);
    expect(cellsOf(mapWith(RIGHT), "occupied").length).toBeGreaterThan(120);
  });

  it("that is wrong puts them elsewhere, each way of being wrong", () => {
    expect(smear({ ...RIGHT, yaw: 0.1 })).toBeGreaterThan(15);
    expect(smear({ ...RIGHT, y: 0.4 })).toBeGreaterThan(15);
    expect(smear({ ...RIGHT, upsideDown: true })).toBeGreaterThan(50);
  });

  it("is forgiving of a robot that never turned: here it turned, and the smear grows with the error", () => {
    const angles = [0, 0.05, 0.1, 0.2].map((yaw) => smear({ ...RIGHT, yaw }));
    expect(angles).toEqual([...angles].sort((a, b) => a - b));
  });
});
