import { expect, test, vi } from "vitest";
import { labelPlaces, numberLabels, rangeWith, TIME_STEPS, timeAxis, timeLabels } from "./plotParts";

test("times on an axis have the decimals that tell them apart", () => {
  expect(timeLabels([0, 60, 120])).toEqual(["0:00", "1:00", "2:00"]);
  expect(timeLabels([59.8, 59.9, 60])).toEqual(["0:59.8", "0:59.9", "1:00.0"]);
  expect(timeLabels([1.25, 1.27])).toEqual(["0:01.25", "0:01.27"]);
  expect(timeLabels([-0.5, 0])).toEqual(["−0:00.5", "0:00.0"]);
});

test("an axis has at least three labels, at round places within it, and no more than have room", () => {
  for (const [low, high] of [
    [0, 100],
    [92.1, 100],
    [-0.013, 0.021],
    [3, 4.99],
    [0, 2691],
    [1e6, 1e6 + 3],
  ] as const) {
    for (const most of [3, 4, 6, 9]) {
      for (const steps of [undefined, TIME_STEPS]) {
        const places = labelPlaces(low, high, most, steps);
        expect(places.length).toBeGreaterThanOrEqual(3);
        expect(places.length).toBeLessThanOrEqual(most);
        expect(places.every((at, n) => at >= low && at <= high && at > (places[n - 1] ?? -1e9))).toBe(true);
      }
    }
  }
  expect(labelPlaces(0, 100, 6)).toEqual([0, 20, 40, 60, 80, 100]);
  expect(labelPlaces(10, 130, 5, TIME_STEPS)).toEqual([30, 60, 90, 120]);
  expect(labelPlaces(0, 19.9, 4)).toEqual([0, 5, 10, 15]);
  expect(labelPlaces(-0.7, 7.9, 3)).toEqual([0, 3, 6]);
  expect(labelPlaces(0, 3.4, 3)).toEqual([0, 1.5, 3]);
  expect(labelPlaces(0.0001, 0.0005, 3, TIME_STEPS)).toHaveLength(3);
});

test("shares of a whole end at 100 %, and numbers on an axis are short", () => {
  expect(rangeWith("%", -4, 108)).toEqual([0, 100]);
  expect(rangeWith("m", -4, 108)).toEqual([-4, 108]);
  expect(numberLabels([-0.25, 1500, 250_000])).toEqual(["−0.25", "1,500", "250K"]);
});

test("times on an axis in UTC are round in UTC, and to the millisecond", () => {
  const start = 1_760_000_000.25; // 2025-10-09 08:53:20.250 UTC
  expect(timeLabels([39.75, 99.75], start)).toEqual(["08:54:00", "08:55:00"]);
  expect(timeLabels([0.5, 0.505], start)).toEqual(["08:53:20.750", "08:53:20.755"]);
  expect(timeLabels([54_399.75, 54_400.75], start)).toEqual(["00:00:00", "00:00:01"]);
  vi.stubGlobal("devicePixelRatio", 1);
  const chart = { axes: [{ side: 2 }], bbox: { width: 400, height: 100 } };
  const splits = timeAxis(70, start).splits as (...given: unknown[]) => number[];
  const places = splits(chart, 0, 0, 120);
  vi.unstubAllGlobals();
  expect(places.length).toBeGreaterThanOrEqual(3);
  for (const text of timeLabels(places, start)) expect(text).toMatch(/^08:5\d:(00|30)$/);
});
