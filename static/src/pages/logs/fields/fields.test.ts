import { expect, test } from "vitest";
import type { SeriesAnswer } from "../../../wire/http";
import { type Chosen, csvOf, joined, labelOf, matching, paired, valueAt, withField } from "./fields";

const chosen = (field: string): Chosen => ({ topic: "/imu", field, made: "value", window: 1 });
const series = (
  times: number[],
  values: (number | null)[],
  gaps: [number, number][] = [],
  unit = "m",
): SeriesAnswer => ({
  topic: "/imu",
  type: "x/Y",
  samples: times.length,
  gaps,
  times,
  columns: [{ label: "z", unit, plot: "", values }],
});
const A = { chosen: chosen("a.z"), series: series([0, 1, 2], [1, 2, null]) };
const B = { chosen: chosen("b, c"), series: series([0.5, 1, 3], [10, 20, 40], [[1, 3]], "") };

test("fields are found by every word of a text", () => {
  const topics = [
    { topic: "/imu", type: "x/Y", fields: ["angular_velocity.z", "linear.z"], why: "", frames: [], computed: false },
  ];
  expect(matching(topics, "VELOCITY imu", 5)).toEqual([{ topic: "/imu", field: "angular_velocity.z" }]);
  expect(matching(topics, "z", 1)).toHaveLength(1);
  expect(matching(topics, "x", 5)).toEqual([]);
});

test("fields of different times share a row of times", () => {
  const found = joined([A, B]);
  expect(found.times).toEqual([0, 0.5, 1, 2, 3]);
  expect(found.columns.map(({ values }) => values)).toEqual([
    [1, null, 2, null, null],
    [null, 10, 20, null, 40],
  ]);
  expect(csvOf(found, 1_760_000_000.25).split("\n").slice(0, 3)).toEqual([
    'time_s,time_utc,/imu a.z (m),"/imu b, c"',
    "0,2025-10-09T08:53:20.250Z,1,",
    "0.5,2025-10-09T08:53:20.750Z,,10",
  ]);
  expect(csvOf(found, null)).toBe('time_s,/imu a.z (m),"/imu b, c"\n0,1,\n0.5,,10\n1,2,20\n2,,\n3,,40\n');
});

test("over another field the others are taken at its times, not across a gap", () => {
  expect(valueAt(B.series, 0.75)).toBe(15);
  expect([0.4, 2, 3.1].map((time) => valueAt(B.series, time))).toEqual([null, null, null]);
  expect(valueAt(B.series, 3)).toBe(40);
  const found = paired([A, B], "/imu a.z");
  expect(found?.times).toEqual([0, 1, 2]);
  expect(found?.columns.map(({ values }) => values)).toEqual([
    [1, 2, null],
    [null, 20, null],
  ]);
  expect(paired([A], "/imu b")).toBeNull();
});

test("what is made of a field is in its label", () => {
  expect(labelOf({ ...chosen("z"), made: "derivative" })).toBe("d/dt /imu z");
  expect(labelOf({ ...chosen("z"), made: "average", window: 5 })).toBe("/imu z, mean of 5 s");
});

test("a field is plotted once", () => {
  const field = { topic: "/imu", field: "a.z" };
  const one = withField([], field);
  expect(one).toEqual([chosen("a.z")]);
  expect(withField(one, field)).toBe(one);
  expect(withField(one, { ...field, topic: "/odom" }).map(({ topic }) => topic)).toEqual(["/imu", "/odom"]);
});
