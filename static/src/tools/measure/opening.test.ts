import { expect, test } from "vitest";
import { Cells } from "../../render/map/cells";
import type { MapPicture } from "../../render/map/mapPicture";
import { type Point, TILE } from "../../wire/protocol";
import { distanceOf } from "./model";
import { opening } from "./tool";

const RESOLUTION = 0.05;
const WIDTH = 0.9;
const THICK = 0.12;

/** A wall through the middle of the map at an angle, with a door; cells with a piece of its surface are occupied. */
function wallWithDoor(angle: number, shift: number) {
  const cells = new Cells();
  const tile = new Int8Array(TILE * TILE).fill(-100);
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const centre = (RESOLUTION * TILE) / 2 + shift;
  /** A place along the wall and across it, metres. */
  const at = (along: number, across: number): Point => [
    centre + along * cos - across * sin,
    centre + along * sin + across * cos,
  ];
  const mark = ([x, y]: Point): void => {
    const [col, row] = [Math.floor(x / RESOLUTION), Math.floor(y / RESOLUTION)];
    if (col >= 0 && col < TILE && row >= 0 && row < TILE) tile[row * TILE + col] = 120;
  };
  for (const side of [-1, 1]) {
    for (let k = 0; k <= 400; k++) {
      for (const across of [-THICK / 2, THICK / 2]) mark(at(side * (WIDTH / 2 + k * 0.002), across));
      mark(at((side * WIDTH) / 2, (k / 400 - 0.5) * THICK));
    }
  }
  cells.setTile(0, 0, new Uint8Array(tile.buffer));
  const geometry = { resolution: RESOLUTION, rows: TILE, cols: TILE, origin: [0, 0, 0], low: -3, high: 3 };
  const map: MapPicture = { cells, style: "belief", geometry: geometry as unknown as MapPicture["geometry"] };
  return { map, at };
}

const DEGREES = [0, 7, 20, 33, 45, 60, 81, 90, 120, 163];

test.each(DEGREES)("a door of 0.9 m in a wall at %d degrees is measured within a cell", (degrees) => {
  const all: number[] = [];
  for (const shift of [0, 0.011, 0.023, 0.037]) {
    const { map, at } = wallWithDoor((degrees * Math.PI) / 180, shift);
    // Clicks on the jambs that are not opposite each other, nor exactly on them.
    for (const [a, b, off] of [
      [-0.05, 0.05, 0.03],
      [0.06, -0.04, -0.04],
      [0, 0, 0],
    ] as const) {
      const found = opening(map, at(-WIDTH / 2 + off, a), at(WIDTH / 2 - off, b), 0.15);
      expect(found).not.toBeNull();
      if (found) all.push(distanceOf(...found));
    }
  }
  expect(Math.min(...all)).toBeGreaterThan(WIDTH - RESOLUTION);
  expect(Math.max(...all)).toBeLessThan(WIDTH + RESOLUTION);
});

test("where a wall stands between, or there is none, nothing is an opening", () => {
  const { map, at } = wallWithDoor(0, 0);
  expect(opening(map, at(-0.6, -0.2), at(-0.6, 0.2), 0.15)).toBeNull();
  expect(opening(map, at(0, -0.5), at(0, 0.5), 0.15)).toBeNull();
});
