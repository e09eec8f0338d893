import { describe, expect, it } from "vitest";
import type { Bounds } from "../../grid/lattice";
import { fitted, toWorld } from "../../render/view";
import { centredAt, overviewBox } from "./Overview";

// @vitest-environment happy-dom

const bounds: Bounds = [-20, -10, 40, 20];
const picture = { width: 900, height: 700 };

describe("the overview of a map", () => {
  it("is not there while the whole map is seen, nor in a small picture", () => {
    const all = fitted(bounds, picture);
    expect(overviewBox(bounds, all, picture)).toBeNull();
    const near = { x: 0, y: 0, scale: all.scale / 4 };
    expect(overviewBox(bounds, near, picture)).not.toBeNull();
    expect(overviewBox(bounds, near, { width: 390, height: 420 })).toBeNull();
    expect(overviewBox([0, 0, 0, 0], { x: 9, y: 9, scale: 0.001 }, picture)).toBeNull();
  });

  it("has the shape of the map, and frames what the picture shows of the world", () => {
    const view = { x: 25, y: 5, scale: 0.01 };
    const box = overviewBox(bounds, view, picture);
    if (!box) throw new Error("There is no overview.");
    expect(box.size.width / box.size.height).toBeCloseTo(60 / 30, 1);
    const [left, top, width, height] = box.shown;
    const corner = toWorld(box.whole, box.size, left, top);
    const other = toWorld(box.whole, box.size, left + width, top + height);
    expect(corner[0]).toBeCloseTo(25 - 4.5);
    expect(corner[1]).toBeCloseTo(5 + 3.5);
    expect(other[0]).toBeCloseTo(25 + 4.5);
    expect(other[1]).toBeCloseTo(5 - 3.5);
  });

  it("is there for a map that was moved out of sight", () => {
    expect(overviewBox(bounds, { x: 500, y: 0, scale: 0.2 }, picture)).not.toBeNull();
  });

  it("moves the view no farther than to the map's edge", () => {
    const view = { x: 0, y: 0, scale: 0.01 };
    expect(centredAt(view, bounds, [7, 8])).toEqual({ x: 7, y: 8, scale: 0.01 });
    expect(centredAt(view, bounds, [99, -99])).toEqual({ x: 40, y: -10, scale: 0.01 });
  });
});
