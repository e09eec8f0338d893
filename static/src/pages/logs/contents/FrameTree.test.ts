import { describe, expect, it } from "vitest";
import type { FrameEdgeAnswer } from "../../../wire/http";
import { ageLabel, rateLabel } from "./contents";
import { isLate, placedFrames } from "./FrameTree";

const edge = (parent: string, child: string, more: Partial<FrameEdgeAnswer> = {}): FrameEdgeAnswer => ({
  parent,
  child,
  static: false,
  count: 10,
  rate_hz: 10,
  age_s: 0.05,
  used: true,
  ...more,
});

const NAMES = ["base", "camera", "laser", "map", "odom"];

describe("the tree of frames", () => {
  it("is one line per frame, children under their parents", () => {
    const edges = [edge("base", "laser"), edge("base", "camera"), edge("odom", "base"), edge("map", "odom")];
    const lines = placedFrames(NAMES, edges, "map").map(({ name, depth, parentLine }) => [name, depth, parentLine]);
    expect(lines).toEqual([
      ["map", 0, null],
      ["odom", 1, 0],
      ["base", 2, 1],
      ["laser", 3, 2],
      ["camera", 3, 2],
    ]);
  });

  it("shows trees that are not joined, that of the fixed frame first", () => {
    const lines = placedFrames(NAMES, [edge("map", "odom"), edge("base", "laser")], "odom");
    expect(lines.map(({ name, depth }) => [name, depth])).toEqual([
      ["map", 0],
      ["odom", 1],
      ["base", 0],
      ["laser", 1],
      ["camera", 0],
    ]);
  });

  it("shows each frame of a loop once, and follows one of two parents", () => {
    const loop = [edge("a", "b"), edge("b", "c"), edge("c", "a"), edge("x", "b", { used: false })];
    expect(
      placedFrames(["a", "b", "c", "x"], loop, "b")
        .map(({ name }) => name)
        .sort(),
    ).toEqual(["a", "b", "c", "x"]);
  });

  it("marks what is late for its rate", () => {
    expect(isLate(edge("a", "b", { age_s: 0.15 }))).toBe(false);
    expect(isLate(edge("a", "b", { age_s: 0.25 }))).toBe(true);
    expect(isLate(edge("a", "b", { age_s: 3, rate_hz: 0.5 }))).toBe(false);
    expect(isLate(edge("a", "b", { age_s: null }))).toBe(true);
    expect(isLate(edge("a", "b", { age_s: 900, static: true }))).toBe(false);
  });

  it("writes rates and ages", () => {
    expect([rateLabel(197.4), rateLabel(10), rateLabel(0.02), rateLabel(null)]).toEqual([
      "197 Hz",
      "10.0 Hz",
      "every 50 s",
      "–",
    ]);
    expect([ageLabel(0.0304), ageLabel(3.42), ageLabel(125.2)]).toEqual(["30 ms", "3.4 s", "2:05 min"]);
  });
});
