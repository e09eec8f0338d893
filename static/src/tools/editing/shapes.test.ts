import { expect, test } from "vitest";
import type { Point, WorldMessage } from "../../wire/protocol";
import { clampedToWorld, editsWithout, outline, shapeOfStroke, solidAt } from "./shapes";

const square = (x0: number, y0: number, x1: number, y1: number): readonly Point[] => [
  [x0, y0],
  [x1, y0],
  [x1, y1],
  [x0, y1],
];

const WORLD = {
  bounds: [0, 0, 10, 8],
  polygons: [square(0, 0, 10, 0.2), square(2, 2, 3, 3), square(5, 5, 6, 6), square(5.5, 5.5, 7, 7)],
  ids: [0, 4, -1, -2],
  edits: { added: [["box", 500, 500, 600, 600] as const, ["box", 550, 550, 700, 700] as const], erased: [1] },
} as unknown as WorldMessage;

test("a stroke becomes a shape of whole centimetres, straightened and snapped", () => {
  expect(shapeOfStroke("box", [1.02, 1.48], [2.513, 0.99])).toEqual(["box", 100, 150, 250, 100]);
  expect(shapeOfStroke("wall", [1, 1], [4, 1.2])).toEqual(["wall", 100, 100, 400, 100]);
  expect(shapeOfStroke("wall", [1, 1], [1.1, -3])).toEqual(["wall", 100, 100, 100, -300]);
  expect(shapeOfStroke("wall", [1, 1], [3, 3])).toEqual(["wall", 100, 100, 300, 300]);
});

test("a slip of the hand draws nothing", () => {
  expect(shapeOfStroke("wall", [1, 1], [1.04, 1.04])).toBeNull();
  expect(shapeOfStroke("box", [1, 1], [4, 1.04])).toBeNull();
});

test("a wall's outline is as thick as the core's", () => {
  const points = outline(["wall", 0, 0, 300, 400]);
  const [a, b, , d] = points as [Point, Point, Point, Point];
  expect(Math.hypot(b[0] - a[0], b[1] - a[1])).toBeCloseTo(5);
  expect(Math.hypot(d[0] - a[0], d[1] - a[1])).toBeCloseTo(0.12);
  expect(outline(["box", 0, 0, 100, 200])).toEqual(square(0, 0, 1, 2));
});

test("the solid under a place, the nearest within reach, never the outer wall", () => {
  expect(solidAt(WORLD, [2.5, 2.5], 0.2)).toBe(1);
  expect(solidAt(WORLD, [3.1, 2.5], 0.2)).toBe(1);
  expect(solidAt(WORLD, [3.3, 2.5], 0.2)).toBeNull();
  expect(solidAt(WORLD, [5, 0.1], 0.2)).toBeNull();
  expect(solidAt(WORLD, [5.7, 5.7], 0.2)).toBe(3); // drawn last, so it lies on top
});

test("what was drawn is taken from the drawn, what was built is noted as erased", () => {
  expect(editsWithout(WORLD, 1)).toEqual({ added: WORLD.edits.added, erased: [1, 4] });
  expect(editsWithout(WORLD, 2)).toEqual({ added: [["box", 550, 550, 700, 700]], erased: [1] });
});

test("strokes stay in the world", () => {
  expect(clampedToWorld([-3, 20], [0, 0, 10, 8], 0.1)).toEqual([0.1, 7.9]);
});
