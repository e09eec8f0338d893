import { expect, test } from "vitest";
import type { ScoreLandscape } from "../../wire/http";
import { pairAt, placeAt, presentIn, summitOf } from "./scoreLandscape";

const LANDSCAPE: ScoreLandscape = {
  edge: 4,
  cell_m: 0.5,
  turn_deg: 90,
  size: 3,
  scores: [10, 20, 30, 40, 50, 95, 60, 70, 80],
  turn_of: [0, 1, 2, 0, 1, 2, 0, 1, 2],
  by_turn: [60, 70, 95],
  centre: [10, 20, 0],
  present: [10.25, 19.5, 0.1],
};

test("a cell has a score, and the distance and turn from the loop's measurement", () => {
  expect(placeAt(LANDSCAPE, 1, 1)).toMatchObject({ score: 50, dx: 0, dy: 0, turnDeg: 0 });
  expect(placeAt(LANDSCAPE, 9, -3)).toMatchObject({ col: 2, row: 0, score: 30, dx: 0.5, dy: -0.5, turnDeg: 90 });
  expect(summitOf(LANDSCAPE)).toMatchObject({ col: 2, row: 1, score: 95 });
  expect(presentIn(LANDSCAPE)).toEqual([1.5, 0]);
});

test("the later scan is moved and turned about where the loop puts it", () => {
  const pair = { scans: [0, 1] as const, poses: [], points: { i: [], j: [], aligned: [[11, 20]] as const } };
  const [[x, y] = [0, 0]] = pairAt(pair, LANDSCAPE, placeAt(LANDSCAPE, 2, 1)).points.aligned ?? [];
  expect([x, y]).toEqual([expect.closeTo(10.5), expect.closeTo(21)]);
});
