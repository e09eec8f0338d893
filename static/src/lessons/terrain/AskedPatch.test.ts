import { expect, test } from "vitest";
import { heightsOf, limitsOf, placesOf } from "./AskedPatch";
import { momentsOf, planeOf, ratiosOf, scoreOf, stepOf } from "./model";

// @vitest-environment happy-dom

const VALUES = {
  max_slope: 45,
  max_roughness: 0.5,
  max_step: 0.5,
  slope_weight: 1,
  roughness_weight: 1,
  step_weight: 0.5,
  rule: "weighted_sum",
};

test("the points of a message, and heights with room to drag them", () => {
  const points = placesOf([0, 0, 1, 0.5, 0, 2]);
  expect(points).toEqual([
    [0, 0, 1],
    [0.5, 0, 2],
  ]);
  const [low, high] = heightsOf(points, 0.5);
  expect(low).toBeLessThan(1);
  expect(high).toBeGreaterThan(2.2);
});

test("a level patch beside one that is half a metre higher has that step, and it counts by its weight", () => {
  const plane = planeOf(momentsOf(placesOf([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0])));
  if (!plane) throw new Error("no plane");
  const edges = placesOf([1, 0, 0.5, -1, 0, -0.1]);
  expect(stepOf(plane, edges)).toBeCloseTo(0.5);
  expect(ratiosOf(plane, limitsOf(VALUES), edges).map(({ value }) => value)).toEqual([0, 0, 0.5]);
  expect(scoreOf(plane, limitsOf(VALUES), edges)).toBeCloseTo(0.5);
});

test("thresholds take the greatest ratio, the weighted sum adds them", () => {
  const plane = planeOf(momentsOf(placesOf([-1, -1, -0.6, 1, -1, 0.6, 1, 1, 0.6, -1, 1, -0.6])));
  if (!plane) throw new Error("no plane");
  const edges = placesOf([1, 0, 1.2]);
  const slope = Math.atan(0.6) / (Math.PI / 4);
  expect(scoreOf(plane, limitsOf(VALUES), edges)).toBeCloseTo(slope + 0.5 * (0.6 / 0.5));
  expect(scoreOf(plane, limitsOf({ ...VALUES, rule: "thresholds" }), edges)).toBeCloseTo(slope);
});
