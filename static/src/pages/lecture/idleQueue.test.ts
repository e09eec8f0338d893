// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { enqueueIdleTask } from "./awaitedFigures";

let idle: (() => void)[] = [];

/** Let time pass and say that the browser is idle; tasks that were asked for within are run. */
function rest(ms = 60): void {
  vi.advanceTimersByTime(ms);
  for (const task of idle.splice(0)) task();
}

beforeEach(() => {
  vi.useFakeTimers();
  idle = [];
  vi.stubGlobal("requestIdleCallback", (task: () => void) => idle.push(task));
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("tasks are run one at a time, in the order in which they came, each after a rest", () => {
  const ran: string[] = [];
  for (const name of ["a", "b", "c"]) enqueueIdleTask(() => ran.push(name));
  expect(ran).toEqual([]);
  rest();
  expect(ran).toEqual(["a"]);
  rest(20);
  expect(ran).toEqual(["a"]);
  rest();
  rest();
  expect(ran).toEqual(["a", "b", "c"]);
  enqueueIdleTask(() => ran.push("d"));
  rest();
  expect(ran).toEqual(["a", "b", "c", "d"]);
});

test("a task that was called off is not run, and one that calls others off neither stops nor doubles the rest", () => {
  const ran: string[] = [];
  const off = enqueueIdleTask(() => ran.push("a"));
  const both = enqueueIdleTask(() => {
    ran.push("b");
    both();
  });
  enqueueIdleTask(() => ran.push("c"));
  off();
  rest();
  expect(ran).toEqual(["b"]);
  rest();
  expect(ran).toEqual(["b", "c"]);
  enqueueIdleTask(() => ran.push("d"))();
  rest();
  rest();
  expect(ran).toEqual(["b", "c"]);
});

test("while a hand is at work nothing is run", () => {
  const ran: string[] = [];
  enqueueIdleTask(() => ran.push("a"));
  for (let i = 0; i < 10; i++) {
    vi.advanceTimersByTime(30);
    dispatchEvent(new Event("wheel"));
  }
  rest(30);
  expect(ran).toEqual([]);
  rest();
  expect(ran).toEqual(["a"]);
});
