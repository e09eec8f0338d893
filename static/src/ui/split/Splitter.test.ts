import { expect, test } from "vitest";
import { keyedShare, limited } from "./Splitter";

const LIMITS = { low: 0.2, high: 0.8 };

test("keys move the border by steps, within its limits", () => {
  expect(keyedShare("ArrowRight", 0.5, LIMITS)).toBe(0.52);
  expect(keyedShare("PageUp", 0.5, LIMITS)).toBe(0.4);
  expect(keyedShare("ArrowLeft", 0.21, LIMITS)).toBe(0.2);
  expect(keyedShare("End", 0.5, LIMITS)).toBe(0.8);
  expect(keyedShare("a", 0.5, LIMITS)).toBeNull();
});

test("a border that is dragged away stops at its limit", () => {
  expect([-1, 0.5, 3].map((share) => limited(share, LIMITS))).toEqual([0.2, 0.5, 0.8]);
});
