import { expect, test } from "vitest";
import { scansAt, secondsAt } from "./scanTimes";

const EACH = { every: 1, stamps: [0, 0.1, 0.2, 0.3] };
const SOME = { every: 4, stamps: [0, 4, 8] }; // of scans 1, 5 and 9, one a second

test("a scan has its time, and the time its scan", () => {
  expect([1, 2, 4].map((index) => secondsAt(EACH, index))).toEqual([0, 0.1, 0.3]);
  expect([0, 0.1, 0.25, 9].map((at) => scansAt(EACH, at, 4))).toEqual([1, 2, 3, 4]);
  expect(scansAt(EACH, -1, 4)).toBe(1);
});

test("between known times scans are even", () => {
  expect([1, 3, 5, 9].map((index) => secondsAt(SOME, index))).toEqual([0, 2, 4, 8]);
  expect([0, 2, 2.9, 4, 8].map((at) => scansAt(SOME, at, 9))).toEqual([1, 3, 3, 5, 9]);
});
