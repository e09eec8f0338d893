import { expect, test } from "vitest";
import { velocity } from "./keyboard";

test("two keys at once drive a curve, opposite ones stand still", () => {
  expect(velocity(["KeyW", "ArrowUp"])).toEqual([0.8, 0]);
  const [linear, angular] = velocity(["KeyW", "KeyA"]);
  expect(linear).toBeGreaterThan(0);
  expect(angular).toBeGreaterThan(0);
  expect(velocity(["KeyA", "KeyD"])[1]).toBe(0);
  expect(velocity([])).toEqual([0, 0]);
});
