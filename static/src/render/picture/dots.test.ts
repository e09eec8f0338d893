// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { stamp } from "./overlays";

const lit = (x: number, y: number, side: number): number[] => {
  const pixels = new Uint32Array(20);
  stamp(pixels, 5, 4, x, y, side, 7);
  return [...pixels.keys()].filter((i) => pixels[i] === 7);
};

test("a dot is a square of pixels around its place", () => {
  expect(lit(2.5, 1.5, 3)).toEqual([1, 2, 3, 6, 7, 8, 11, 12, 13]);
  expect(lit(2.5, 1.5, 1)).toEqual([7]);
});

test("the part of a dot outside the picture is left out, on each side", () => {
  expect(lit(0.5, 0.5, 3)).toEqual([0, 1, 5, 6]);
  expect(lit(4.5, 3.5, 3)).toEqual([13, 14, 18, 19]);
  expect(lit(-9, 1, 3)).toEqual([]);
  expect(lit(30, 1, 3)).toEqual([]);
  expect(lit(2, 90, 3)).toEqual([]);
});
