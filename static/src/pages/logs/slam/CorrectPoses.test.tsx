import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import { Store } from "../../../store/store";
import type { Command } from "../../../wire/protocol";
import { PUSH } from "../push.fixture";
import type { SlamStatus } from "./api";
import { Outcome } from "./CorrectPoses";

// @vitest-environment happy-dom

afterEach(() => render(null, document.body));

const HEALED: SlamStatus = {
  state: "done",
  created_s: 0,
  error: null,
  fraction: 1,
  elapsed_s: 1,
  ahead: 0,
  log: "a",
  topic: null,
  odometry: null,
  parameters: {},
  stage: null,
  scans: 0,
  loops: 0,
  result: {
    trajectory: "SLAM",
    odometry: "odom",
    loops: 2,
    nodes: 400,
    cpu_s: 1,
    drift_m: [0.6, 0.1],
    contradicted: [0.2, 0.01],
    sharpness: [0.5, 0.6],
    notes: [],
  },
};

test("what the wheels did not measure stands in the result, with a button that goes there", () => {
  const sent: Command[] = [];
  const store = new Store((command) => sent.push(command) > 0);
  act(() => render(<Outcome job={HEALED} store={store} events={[PUSH]} />, document.body));
  expect(document.body.textContent).toContain("The robot moved 0.40 m to its left, which the wheels did not measure.");
  document.querySelector("button")?.click();
  expect(sent.at(-1)).toEqual({ type: "seek", index: 367 });
});

test("without events there is no heading for them", () => {
  act(() => render(<Outcome job={HEALED} store={new Store(() => true)} events={[]} />, document.body));
  expect(document.querySelector("h4")).toBeNull();
});
