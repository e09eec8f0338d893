import { describe, expect, it } from "vitest";
import type { Trajectory } from "../../../wire/protocol";
import { keyedPlace, nearest, placeOfScan, scanAtPlace, shownRange, zoomedSpan } from "./strips";

const trajectory = (stamps: number[], every = 1): Trajectory => ({
  type: "trajectory",
  frame: null,
  name: "odom",
  every,
  poses: stamps.map(() => [0, 0] as const),
  stamps,
});

describe("the place of a scan on the axis", () => {
  it("leads back to the scan, with times and without", () => {
    const timed = trajectory([0, 0.5, 2, 2.5]);
    for (const index of [1, 2, 3, 4]) {
      expect(scanAtPlace("time", timed, placeOfScan("time", timed, index), 4)).toBe(index);
      expect(scanAtPlace("scan", timed, placeOfScan("scan", timed, index), 4)).toBe(index);
    }
  });

  it("is between the stamps that the page has", () => {
    expect(placeOfScan("time", trajectory([0, 1, 2], 10), 6)).toBeCloseTo(0.5);
  });
});

describe("the value at a place", () => {
  it("is the nearest one", () => {
    expect([-1, 0.4, 0.6, 1, 9].map((at) => nearest([0, 1, 2], at))).toEqual([0, 0, 1, 1, 2]);
    expect(nearest([], 0)).toBe(-1);
  });
});

describe("the range of the y axis", () => {
  it("has all values where none is far outside", () => {
    const shown = shownRange([0, null, 1, 2]);
    expect(shown?.beyond).toBeNull();
    expect(shown?.low).toBeLessThan(0);
    expect(shown?.high).toBeGreaterThan(2);
  });

  it("leaves out an outlier and states it", () => {
    const values = Array.from({ length: 200 }, (_, n) => Math.sin(n));
    const shown = shownRange([...values, 56.5]);
    expect(shown?.beyond).toBe(56.5);
    expect(shown?.high).toBeLessThan(4);
    expect(shown?.low).toBeLessThan(-1);
  });

  it("has room around values that are all the same, and is none without values", () => {
    const shown = shownRange([100, 100]);
    expect([shown?.beyond, (shown?.low ?? 0) < 100, (shown?.high ?? 0) > 100]).toEqual([null, true, true]);
    expect(shownRange([null, null])).toBeNull();
  });

  it("states no outlier where nearly all values are the same and one is not", () => {
    const shown = shownRange([...Array.from({ length: 300 }, () => 0.1), 12]);
    expect([shown?.beyond, (shown?.high ?? 0) > 12]).toEqual([null, true]);
  });
});

describe("keys and zoom", () => {
  it("moves by a part of the interval and stays in it", () => {
    expect(keyedPlace("ArrowRight", false, 50, [0, 100])).toBe(51);
    expect(keyedPlace("ArrowLeft", true, 5, [0, 100])).toBe(0);
    expect(keyedPlace("End", false, 5, [0, 100])).toBe(100);
    expect(keyedPlace("a", false, 5, [0, 100])).toBeNull();
  });

  it("keeps the place where it is, and the interval within the whole one", () => {
    expect(zoomedSpan([0, 100], [0, 100], 25, 0.5)).toEqual([12.5, 62.5]);
    expect(zoomedSpan([90, 100], [0, 100], 100, 2)).toEqual([80, 100]);
    expect(zoomedSpan([0, 60], [0, 100], 30, 2)).toBeNull();
  });
});
