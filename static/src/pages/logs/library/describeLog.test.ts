import { expect, test } from "vitest";
import { file, inside, lidars, readingText, remedy, run, sentence, topic, trajectoryLabel } from "./describeLog";
import type { LogRecord, Topic } from "./library";

const OWN = { source: "log", created_s: null, has_graph: false } as const;
const CENTRE = [0, 0, 0] as const;

const intel: LogRecord = {
  id: "folder-1",
  name: "intel.log.gz",
  source: "folder",
  state: "ready",
  bytes: 447_000,
  progress: 1,
  reading_s: null,
  error: null,
  has_picture: false,
  tags: [],
  scans: 13_631,
  costmaps: 0,
  clouds: 0,
  points: 0,
  map: null,
  beams: 180,
  duration_s: 2650.86,
  format: "CARMEN FLASER",
  trajectories: [
    { ...OWN, name: "scan", description: "the pose in each FLASER line", length_m: 501.1 },
    { ...OWN, name: "wheel", description: "the ODOM messages at the time of each scan", length_m: 501.1 },
  ],
  time: { start_s: 1_000_000_000, rate_hz: 3.35, gaps: 2, longest_gap_s: 61.5, longest_gap_at_s: 125 },
  mount: [0.2, -0.1, Math.PI],
  upside_down: true,
  topics: [],
  notes: [],
};

test("a run is told by its time, its way and its scans", () => {
  expect(run(intel)).toEqual(["44:10", "501 m driven", "13,631 scans"]);
  expect(file(intel)).toEqual(["180 beams", "CARMEN FLASER", "447 kB"]);
});

test("a map is told by its size", () => {
  const map = { ...intel, scans: 0, map: { rows: 400, cols: 1200, resolution: 0.05 }, format: "map" };
  expect(run(map)).toEqual(["60 m × 20 m", "cells of 5.0 cm"]);
  expect(file(map)).toEqual(["map", "447 kB"]);
});

test("what a log does not tell is not told", () => {
  const still = { ...intel, duration_s: 0, trajectories: [{ ...OWN, name: "scan", description: "", length_m: 0 }] };
  expect(run(still)).toEqual(["13,631 scans"]);
  const unread = { ...intel, scans: null, beams: null, duration_s: null, format: null, trajectories: [] };
  expect(run(unread)).toEqual([]);
  expect(file(unread)).toEqual(["447 kB"]);
});

test("the reading is told by its share and its time", () => {
  expect(readingText({ ...intel, state: "reading", progress: 0.437, reading_s: 12.8 })).toBe("being read: 43 %, 12 s");
  expect(readingText({ ...intel, state: "reading", progress: 0, reading_s: 75 })).toBe("being read: 0 %, 1:15");
  expect(readingText({ ...intel, state: "queued", progress: 0 })).toBe("waits to be read");
});

test("what is inside is told in plain words", () => {
  expect(inside(intel)).toEqual([
    "Recorded 2001-09-09 01:46 UTC",
    "3.4 scans a second; 2 gaps, the longest of 61.5 s at 2:05.000",
    "Sensor 0.20 m ahead, 0.10 m to the right, turned by 180°, upside-down",
  ]);
  const plain = { ...intel, time: null, mount: CENTRE, upside_down: false };
  expect(inside(plain)).toEqual(["Sensor at the robot’s centre"]);
  expect(inside({ ...intel, time: null, mount: null })).toEqual([]);
});

test("a topic is told in a line", () => {
  const scan: Topic = {
    name: "/scan",
    type: "sensor_msgs/LaserScan",
    count: 1200,
    frame: "laser",
    beams: 360,
    field_of_view_deg: 359,
    rate_hz: 10,
    mount: null,
    chosen: true,
  };
  const unplaced = { ...intel, time: null, mount: CENTRE, topics: [scan] };
  expect(inside(unplaced)).toEqual(["Sensor mount not stated in the file; the robot’s centre is assumed"]);
  expect(topic(scan)).toBe("1,200 × LaserScan, 360 beams, 359°, 10.0 Hz, frame laser");
  const imu = { ...scan, type: "sensor_msgs/Imu", frame: null, beams: null, field_of_view_deg: null, rate_hz: null };
  expect(topic(imu)).toBe("1,200 × Imu");
  const other = { ...scan, name: "/scan#/tf_gt", chosen: false };
  expect(topic(other)).toMatch(/frame laser, frames looked up in \/tf_gt$/);
  const rear = { ...other, name: "/rear" };
  expect(lidars({ ...intel, topics: [scan, other, rear] })).toEqual(["/scan", "/rear"]);
});

test("an unknown trajectory keeps its own name", () => {
  expect(trajectoryLabel("wheel")).toBe("wheel odometry");
  expect(trajectoryLabel("vicon")).toBe("vicon");
  expect(trajectoryLabel("tf/map")).toBe("tf, in map");
});

test("a phrase becomes a sentence, a sentence stays one", () => {
  expect(sentence("the pose in each FLASER line")).toBe("The pose in each FLASER line.");
  expect(sentence("Where it truly was.")).toBe("Where it truly was.");
});

test("a log that failed comes with something to do about it", () => {
  const failed = (code: string, message: string): LogRecord => ({
    ...intel,
    state: "failed",
    error: { code, message },
  });
  expect(remedy(failed("log.unknown_format", "The file is a ROS 1 bag."))).toContain("Convert other formats");
  expect(remedy(failed("log.too_many_lines", "The log has more lines than the limit."))).toContain("shorter");
  expect(remedy(failed("log.no_scans", "The log holds no scans."))).toContain("range readings");
  expect(remedy(failed("log.truncated", "The gzip data ends early."))).toContain("Copy");
  expect(remedy(failed("log.truncated_line", "Line 3: this line ends early."))).toContain("that line");
  expect(remedy(failed("log.beams_vary", "Line 3 of measurement.txt has 7 numbers, not 9."))).toContain("that line");
  expect(remedy(failed("log.extent", "The wheels’ ticks put the robot too far away."))).toBe("");
  expect(remedy(failed("log.header", "Before line 5: angle_min cannot be nan."))).toContain("before the scans");
  expect(remedy(failed("log.something_new", "Something else."))).toBe("");
  expect(remedy(failed("log.no_scans", "The log holds no scans."))).toContain("gridbloom info LOG --report");
  expect(remedy(failed("log.too_many_lines", "The log has more lines."))).not.toContain("--report");
});
