// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import { Store } from "../../store/store";
import type { LogEvent } from "../../wire/http";
import type { Command } from "../../wire/protocol";
import { Events, measureOf } from "./Doctor";

afterEach(() => render(null, document.body));

const PUSH: LogEvent = {
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
  sentence: "The robot moved 0.40 m to its left, which the wheels did not measure.",
};

test("going to an event pauses a log that plays", () => {
  const sent: Command[] = [];
  const store = new Store((command) => sent.push(command) > 0);
  act(() => render(<Events events={[PUSH]} store={store} />, document.body));
  document.querySelector("button")?.click();
  expect(sent).toEqual([{ type: "pause" }, { type: "seek", index: 367 }]);
});

test("an event is measured in metres, degrees or seconds", () => {
  const of = (change: Partial<LogEvent>): string => measureOf({ ...PUSH, ...change });
  expect(of({})).toBe("0.40 m left");
  expect(of({ direction: null, distance_m: 0.01, turned_rad: -Math.PI / 6 })).toBe("30°");
  expect(of({ kind: "slipped", direction: "behind" })).toBe("0.40 m");
  expect(of({ kind: "clock", step_s: -1.5 })).toBe("−1.50 s");
  expect(of({ kind: "lifted", distance_m: null })).toBe("");
});
