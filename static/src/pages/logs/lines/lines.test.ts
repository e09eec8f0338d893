import { expect, test } from "vitest";
import { levelName, matching, newestAt, nodesOf, ticksOf } from "./lines";

const line = (seconds: number, level: number, text: string, name = "base") => ({
  seconds,
  level,
  text,
  topic: "/rosout",
  name,
});
const LINES = [line(1, 20, "Ready"), line(2, 30, "Slow"), line(3, 40, "Bumper", "bumper"), line(3.2, 30, "slow again")];

test("lines are chosen by level, node and text", () => {
  expect(matching(LINES, 30, "", "").map(({ seconds }) => seconds)).toEqual([2, 3, 3.2]);
  expect(matching(LINES, 0, "", " SLOW").map(({ seconds }) => seconds)).toEqual([2, 3.2]);
  expect(matching(LINES, 0, "bumper", "")).toHaveLength(1);
  expect(nodesOf(LINES)).toEqual(["base", "bumper"]);
  expect([0, 10, 25, 30, 60].map(levelName)).toEqual(["debug", "debug", "info", "warning", "fatal"]);
});

test("the newest line at a moment is the last one not after it", () => {
  expect([0.5, 1, 2.999, 9].map((at) => newestAt(LINES, at))).toEqual([-1, 0, 1, 3]);
  expect(newestAt([], 1)).toBe(-1);
});

test("a place of the slider has one tick, of the gravest line there", () => {
  const way = { stamps: [0, 1, 2, 3, 4], every: 1 };
  expect(ticksOf(LINES, way, 5, 5)).toEqual([
    { index: 3, isGrave: false },
    { index: 4, isGrave: true },
  ]);
});
