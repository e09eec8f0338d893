// @vitest-environment happy-dom
import { expect, test } from "vitest";
import type { ContentsAnswer } from "../../../wire/http";
import { hasCamera, presetsFor } from "./views";

const recording = (topics: Readonly<Record<string, string>>): ContentsAnswer => ({
  topics: Object.entries(topics).map(([name, type]) => ({ name, type }) as ContentsAnswer["topics"][number]),
  series: [],
  frames: 0,
  pictures: Object.keys(topics),
  notes: [],
  state: "ready",
});

test("layouts with a camera are offered unless a log certainly has none", () => {
  const names = (contents: ContentsAnswer | null) => presetsFor(hasCamera(contents)).map(([name]) => name);
  const clouds = { "/points": "sensor_msgs/PointCloud2" };
  expect(names(recording({ ...clouds, "/camera": "sensor_msgs/Image" }))).toContain("Map and camera");
  expect(names(null)).toContain("Map and camera");
  expect(names(recording(clouds))).not.toContain("Map and camera");
  expect(presetsFor(false).flatMap(([, { views }]) => views)).not.toContain("picture");
});
