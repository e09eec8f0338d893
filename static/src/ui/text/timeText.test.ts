import { expect, test } from "vitest";
import { readTime, timeText } from "./timeText";

const START = 1_760_000_000.25; // 2025-10-09 08:53:20.250 UTC

test("times are written to the millisecond", () => {
  expect([0, 73.4004, 59.9996, 3661.5].map((at) => timeText(at))).toEqual([
    "0:00.000",
    "1:13.400",
    "1:00.000",
    "1:01:01.500",
  ]);
  expect(timeText(-0.25)).toBe("−0:00.250");
  expect(timeText(73.4, START)).toBe("2025-10-09 08:54:33.650 UTC");
});

test("a time that is written is read again", () => {
  for (const at of [0, 73.4, 3661.5]) expect(readTime(timeText(at), null)).toBeCloseTo(at, 6);
  expect(readTime(timeText(73.4, START), START)).toBeCloseTo(73.4, 3);
});

test("times are read as people write them", () => {
  expect(readTime("73.4", null)).toBe(73.4);
  expect(readTime("73,4 s", null)).toBe(73.4);
  expect(readTime(" 1:13.4 ", null)).toBeCloseTo(73.4, 6);
  expect(readTime("08:54:33.65 UTC", START)).toBeCloseTo(73.4, 3);
  expect(readTime("2025-10-09T08:54:33.65Z", START)).toBeCloseTo(73.4, 3);
  expect(["", "soon", "1:2:3:4", "2025-10-09 08:54"].map((text) => readTime(text, null))).toEqual([
    null,
    null,
    null,
    null,
  ]);
});
