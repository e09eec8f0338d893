import { describe, expect, it } from "vitest";
import type { Parameter } from "../../../wire/protocol";
import { faultOf, shownBounds, shownUnit, shownValue, statedValue } from "./CutForm";

const row = (unit: string, low: number, high: number): Parameter => ({
  name: "angle_min",
  label: "First bearing",
  group: "cut",
  kind: "number",
  initial: 0,
  sentence: "",
  unit,
  low,
  high,
  step: 0,
  choices: [],
  only_for: [],
});

describe("values of how scans are cut", () => {
  const bearing = row("rad", -Math.PI, Math.PI);

  it("shows angles in degrees and states them in radians", () => {
    expect([shownValue(bearing, -Math.PI), shownUnit(bearing)]).toEqual([-180, "°"]);
    expect(statedValue(bearing, 90)).toBeCloseTo(Math.PI / 2, 12);
    expect(shownBounds(bearing)).toEqual([-180, 180]);
  });

  it("keeps to the bounds that the server checks, also where degrees are rounded", () => {
    expect(statedValue(bearing, 180)).toBe(Math.PI);
    expect(statedValue(bearing, 400)).toBe(Math.PI);
    expect(statedValue(row("m", -1000, 1000), -2000)).toBe(-1000);
  });

  it("leaves heights in metres, and takes nothing for a number that is none", () => {
    expect(shownValue(row("m", -1000, 1000), 0.25)).toBe(0.25);
    expect(statedValue(row("m", -1000, 1000), Number.NaN)).toBeNaN();
  });

  it("says what is wrong with values that are no cut", () => {
    expect(faultOf({ min_height: 0.5, max_height: 0.5 })).toContain("lowest height");
    expect(faultOf({ angle_min: 1, angle_max: -1 })).toContain("first bearing");
    expect(faultOf({ scan_height: Number.NaN })).toContain("number");
    expect(faultOf({ min_height: 0, max_height: 1, angle_min: -1, angle_max: 1 })).toBeNull();
  });
});
