import { expect, test } from "vitest";
import { commandOf, type Drawing, straightened, turnOf } from "./strokes";

const DRAWING: Drawing = { tool: "brush", state: "free", width: 0.2, isFreehand: false, allows: false, limit: 40 };
const SCALE = 0.01;

test("a line that is nearly level or upright becomes so", () => {
  expect(straightened([1, 1], [4, 1.2])).toEqual([4, 1]);
  expect(straightened([1, 1], [0.9, -3])).toEqual([1, -3]);
  expect(straightened([1, 1], [3, 2])).toEqual([3, 2]);
});

test("the map turns so that a line lies along the nearest axis", () => {
  expect(turnOf([0, 0], [10, 1])).toBeCloseTo(-Math.atan2(1, 10));
  expect(turnOf([0, 0], [1, 10])).toBeCloseTo(Math.PI / 2 - Math.atan2(10, 1));
  expect(turnOf([10, 1], [0, 0])).toBeCloseTo(-Math.atan2(1, 10));
  for (const [x, y] of [
    [3, 1],
    [-2, 5],
    [-4, -4.1],
  ] as const) {
    const angle = Math.atan2(y, x) + turnOf([0, 0], [x, y]);
    expect(Math.abs(Math.sin(2 * angle))).toBeLessThan(1e-12);
    expect(Math.abs(turnOf([0, 0], [x, y]))).toBeLessThanOrEqual(Math.PI / 4 + 1e-12);
  }
});

test("each tool sends its edit", () => {
  const points = [
    [1, 2],
    [1.5, 2.5],
    [3, 3],
  ] as const;
  const of = (change: Partial<Drawing>) => commandOf({ ...DRAWING, ...change }, points, SCALE);
  expect(of({})).toEqual({ type: "map_edit", op: "paint", state: "free", width: 0.2, points });
  expect(of({ tool: "line" })).toMatchObject({
    op: "paint",
    points: [
      [1, 2],
      [3, 3],
    ],
  });
  const corners = [
    [1, 2],
    [3, 2],
    [3, 3],
    [1, 3],
  ];
  expect(of({ tool: "area", state: "unknown" })).toEqual({
    type: "map_edit",
    op: "fill",
    state: "unknown",
    points: corners,
  });
  expect(of({ tool: "area", isFreehand: true })).toMatchObject({ op: "fill", points });
  expect(of({ tool: "keepout" })).toEqual({ type: "map_edit", op: "keepout", value: 100, points: corners });
  expect(of({ tool: "keepout", allows: true })).toMatchObject({ value: 0 });
  expect(of({ tool: "speed" })).toEqual({ type: "map_edit", op: "speed", value: 40, points: corners });
  expect(of({ tool: "speed", limit: 0 })).toMatchObject({ value: 0 });
  expect(of({ tool: "speed", isFreehand: true })).toMatchObject({ op: "speed", points });
  expect(of({ tool: "crop" })).toEqual({
    type: "map_edit",
    op: "crop",
    points: [
      [1, 2],
      [3, 3],
    ],
  });
  expect(of({ tool: "straighten" })).toEqual({ type: "map_edit", op: "rotate", angle: turnOf([1, 2], [3, 3]) });
  expect(of({ tool: "origin" })).toEqual({ type: "map_edit", op: "origin", points: [[1, 2]], angle: Math.atan2(1, 2) });
});

test("a slip of the hand sends nothing; a dot of the brush and a clicked origin do", () => {
  const dot = [
    [1, 1],
    [1.01, 1],
  ] as const;
  for (const tool of ["area", "keepout", "speed", "crop", "straighten"] as const)
    expect(commandOf({ ...DRAWING, tool }, dot, SCALE)).toBeNull();
  expect(commandOf(DRAWING, [[1, 1]], SCALE)).toMatchObject({ op: "paint", points: [[1, 1]] });
  expect(commandOf({ ...DRAWING, tool: "origin" }, dot, SCALE)).toMatchObject({ op: "origin", angle: 0 });
});
