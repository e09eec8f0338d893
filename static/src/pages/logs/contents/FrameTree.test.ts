import { describe, expect, it } from "vitest";
import type { FrameEdgeAnswer } from "../../../wire/http";
import { isLate, placedFrames, unjoinedFrames } from "./FrameTree";
import { ageLabel, rateLabel } from "./labels";

const edge = (parent: string, child: string, more: Partial<FrameEdgeAnswer> = {}): FrameEdgeAnswer => ({
  parent,
  child,
  topic: "/tf",
  static: false,
  count: 10,
  rate_hz: 10,
  age_s: 0.05,
  offset: [1, 0, 0],
  angles: [0, 0, 0],
  publishers: [],
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

  it("tells the frames that messages name and no transform joins, with their topics", () => {
    const edges = [edge("odom", "base"), edge("mast", "camera")];
    const tree = { frames: ["base", "camera", "mast", "odom"], elsewhere: ["b/laser"], edges, fixed: "odom" };
    const topics = [
      { topic: "/odom", frames: ["odom", "base"] },
      { topic: "/left", frames: ["sonar_link"] },
      { topic: "/right", frames: ["sonar_link"] },
      { topic: "/image", frames: ["camera"] },
      { topic: "/b/scan", frames: ["b/laser"] },
    ];
    expect(unjoinedFrames(topics, tree)).toEqual([
      { name: "b/laser", topics: ["/b/scan"], lacks: "it is in other transforms of the log" },
      { name: "camera", topics: ["/image"], lacks: "no transform joins it with odom" },
      { name: "sonar_link", topics: ["/left", "/right"], lacks: "no transform names it" },
    ]);
    expect(unjoinedFrames(topics.slice(1, 2), null)).toEqual([
      { name: "sonar_link", topics: ["/left"], lacks: "the log has no transforms" },
    ]);
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
    expect([0.0304, 3.42, 125.2, 3725.2].map(ageLabel)).toEqual(["30 ms", "3.420 s", "2:05.200 min", "1:02:05.200 h"]);
  });
});
