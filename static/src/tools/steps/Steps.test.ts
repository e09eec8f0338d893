import { expect, test } from "vitest";
import { toScreen } from "../../render/view";
import type { Geometry } from "../../wire/protocol";
import { viewWithCell, zoomedInScale } from "./Steps";

const GEOMETRY = { resolution: 0.05, rows: 100, cols: 100, origin: [-1, -2, 0] } as unknown as Geometry;
const SIZE = { width: 400, height: 200 };

const place = (row: number, col: number): [number, number] => [-1 + (col + 0.5) * 0.05, -2 + (row + 0.5) * 0.05];
const [x, y] = place(10, 20);
const VIEW = { x, y, scale: zoomedInScale(GEOMETRY) };

test("from near by a cell is sixteen pixels wide, and its neighbours do not move the view", () => {
  expect(GEOMETRY.resolution / VIEW.scale).toBeCloseTo(16);
  for (const [row, col] of [
    [10, 21],
    [14, 20],
    [10, 28],
  ] as const)
    expect(viewWithCell(VIEW, SIZE, GEOMETRY, { row, col })).toBe(VIEW);
});

test("a cell near the border comes to the middle, at the scale that a person chose", () => {
  for (const scale of [VIEW.scale, VIEW.scale / 2])
    for (const [row, col] of [
      [10, 29],
      [15, 20],
      [80, 80],
    ] as const) {
      const moved = viewWithCell({ ...VIEW, scale }, SIZE, GEOMETRY, { row, col });
      expect(moved.scale).toBe(scale);
      const [px, py] = toScreen(moved, SIZE, ...place(row, col));
      expect([Math.round(px), Math.round(py)]).toEqual([200, 100]);
    }
});
