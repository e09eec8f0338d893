/** An event for tests: a push of 0.40 m to the left. */

import type { LogEvent } from "../../wire/http";

export const PUSH: LogEvent = {
  kind: "pushed",
  seconds: 73.4,
  until_s: 73.6,
  stamp_ns: 0,
  scan: 366,
  until_scan: 368,
  time: "1:13.400",
  utc: null,
  ahead_m: 0,
  left_m: 0.4,
  turned_rad: 0,
  distance_m: 0.4,
  direction: "left",
  step_s: 0,
  moved_m: null,
  sentence: "At 1:13.400 the robot moved 0.40 m to its left, which the wheels did not measure.",
  what: "the robot moved 0.40 m to its left, which the wheels did not measure.",
};
