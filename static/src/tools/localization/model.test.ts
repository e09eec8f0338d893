import { expect, test } from "vitest";
import type { LocalizationMessage } from "../../wire/protocol";
import { ellipseOf, grown, mapOf, type Point, SETTINGS, turned, valuesOf } from "./model";

const message = (n_updates: number, error_m: number | null = 1, is_on = true): LocalizationMessage =>
  ({ type: "localization", is_on, n_updates, error_m, entropy: 3 }) as unknown as LocalizationMessage;

test("the history has a point for each scan that was used", () => {
  let points: readonly Point[] = [];
  for (const [updates, error] of [
    [1, 5],
    [1, 4],
    [2, 3],
  ] as const)
    points = grown(points, message(updates, error));
  expect(points).toEqual([
    { updates: 1, error: 5, entropy: 3 },
    { updates: 2, error: 3, entropy: 3 },
  ]);
});

test("a filter that begins anew, or ends, begins the history anew", () => {
  const points = grown(grown([], message(7)), message(8));
  expect(grown(points, message(1))).toHaveLength(1);
  expect(grown(points, message(8, null, false))).toEqual([]);
});

test("the values of several settings are sent together", () => {
  const [few, sure] = ["few", "sure"].map((name) => SETTINGS.find((one) => one.name === name));
  expect(valuesOf([])).toEqual({});
  expect(valuesOf(["few", "sure"])).toEqual({ ...few?.values, ...sure?.values });
});

test("an ellipse along the line of greatest variance", () => {
  const [long, short, turn] = ellipseOf(0.04, 0, 0.01);
  expect(long).toBeCloseTo(0.2 * Math.sqrt(5.991));
  expect(short).toBeCloseTo(0.1 * Math.sqrt(5.991));
  expect(turn).toBeCloseTo(0);
  const [, none, diagonal] = ellipseOf(1, 1, 1);
  expect(none).toBeCloseTo(0);
  expect(diagonal).toBeCloseTo(Math.PI / 4);
});

test("one setting says which map the filter gets", () => {
  const on = turned(turned(["few"], "moved"), "other");
  expect(on).toEqual(["few", "other"]);
  expect(mapOf(on)).toBe("other");
  expect(mapOf(turned(on, "other"))).toBe("plan");
});
