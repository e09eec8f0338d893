// @vitest-environment happy-dom
import { expect, test } from "vitest";
import type { Forgetting, Frame, Values } from "../../wire/protocol";
import { grown, type Point, passesToForget, placeOf, verdict, withoutClamp } from "./MovingTable";

const scan = (range: (bearing: number) => number | null): Frame =>
  ({
    scan_pose: [4, 3, Math.PI / 2],
    angle_min: -Math.PI,
    angle_increment: (2 * Math.PI) / 360,
    ranges: Array.from({ length: 360 }, (_, i) => range(-Math.PI + (i * 2 * Math.PI) / 360)),
  }) as unknown as Frame;

test("in the open the table stands straight ahead, on whole multiples of five centimetres", () => {
  expect(placeOf(scan(() => 5))).toEqual(["box", 370, 430, 430, 490]);
});

test("where something stands ahead the table stands beside it, and every beam sees beyond it", () => {
  const place = placeOf(scan((bearing) => (Math.abs(bearing) < 0.4 ? 1.2 : 5)));
  const [, x0, y0, x1, y1] = place as [string, number, number, number, number];
  const bearing = Math.atan2((y0 + y1) / 200 - 3, (x0 + x1) / 200 - 4) - Math.PI / 2;
  expect(Math.abs(bearing)).toBeGreaterThan(0.4);
  expect(Math.abs(bearing)).toBeLessThan(1.1);
});

test("in a narrow corridor there is no room for a table", () => {
  expect(placeOf(scan(() => 1))).toBeNull();
  expect(placeOf(scan(() => null))).toBeNull();
});

test("the arithmetic of one cell", () => {
  const values: Values = { log_odds_max: 3.5, log_odds_miss: -0.4 };
  let log_odds = 3.5;
  let passes = 0;
  while (1 / (1 + Math.exp(-log_odds)) >= 0.25) {
    log_odds -= 0.4;
    passes++;
  }
  expect(passesToForget(values)).toBe(passes);
  // With the model's own increments, and of no model that keeps no sum; never where the lower clamp is not free.
  expect(passesToForget({ ...values, model: "step_window", p_free: 0.2, p_occ: 0.7 })).toBe(4);
  expect(passesToForget({ ...values, model: "hit_counting" })).toBeNull();
  expect(passesToForget({ ...values, log_odds_min: -1 })).toBeNull();
});

test("the curve grows by a point for each scan and begins again with a new count", () => {
  const forgetting = (scans: number, free: number): Forgetting =>
    ({ type: "forgetting", cells: 9, scans, free_with_clamp: free, free_without_clamp: 0 }) as unknown as Forgetting;
  let points: readonly Point[] = [];
  for (const [scans, free] of [
    [0, 0],
    [1, 0.1],
    [1, 0.1],
    [3, 0.5],
  ] as const)
    points = grown(points, forgetting(scans, free));
  expect(points.map((p) => [p.scans, p.withClamp])).toEqual([
    [1, 0.1],
    [3, 0.5],
  ]);
  expect(grown(points, forgetting(2, 0.2))).toHaveLength(1);
});

test("what the map without the clamp does is not always slower, and the words do not say so", () => {
  expect(withoutClamp(12, 4)).toContain("faster this time");
  expect(withoutClamp(12, null)).toContain("must outweigh all the hits");
  expect(withoutClamp(12, 76)).toContain("must outweigh all the hits");
});

test("how near the guess came", () => {
  expect(verdict(12, 13)).toBe("You were right.");
  expect(verdict(10, 131)).toBe("It took 13 times as long as you thought.");
  expect(verdict(100, 10)).toBe("It was 10 times as quick as you thought.");
  expect(verdict(20, 30)).toBe("It took longer than you thought.");
});
