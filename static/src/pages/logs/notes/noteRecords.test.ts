import { describe, expect, it } from "vitest";
import type { Trajectory } from "../../../wire/protocol";
import { type Pin, scanOf } from "./noteRecords";

const trajectory = (every: number, stamps: readonly number[]): Trajectory => ({
  type: "trajectory",
  frame: null,
  name: "scan",
  every,
  poses: [],
  stamps,
});
const at = (at_s: number, scan: number): Pin => ({ at_s, scan, x: null, y: null, outline: null });

describe("where a note is on the time slider", () => {
  it("is at its own scan while the log shows the same sensor", () => {
    expect(scanOf(at(0.4, 5), trajectory(1, [0, 0.1, 0.2, 0.3, 0.4, 0.5]), 6)).toBe(5);
    expect(scanOf(at(0.4, 5), trajectory(2, [0, 0.2, 0.4]), 6)).toBe(5);
  });

  it("is at the same time of another sensor", () => {
    expect(scanOf(at(0.4, 5), trajectory(1, [0, 0.4, 0.8]), 3)).toBe(2);
    expect(scanOf(at(0.4, 41), trajectory(10, [0, 1, 2]), 30)).toBe(11);
  });

  it("is at its scan in a log without times, and nowhere without a time", () => {
    expect(scanOf(at(0, 7), trajectory(1, [0, 0, 0]), 20)).toBe(7);
    expect(scanOf(at(0, 70), null, 20)).toBe(20);
    expect(scanOf({ at_s: null, scan: null, x: 1, y: 2, outline: null }, null, 20)).toBeNull();
  });
});
