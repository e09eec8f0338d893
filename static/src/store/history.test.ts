import { beforeEach, expect, test } from "vitest";
import type { Command } from "../wire/protocol";
import { History } from "./history";

let now: number;
let sent: Command[];
let history: History;

const speed = (value: number): Command => ({ type: "speed", value });

beforeEach(() => {
  now = 0;
  sent = [];
  history = new History(
    (command) => sent.push(command),
    () => now,
  );
});

test("changes are undone and redone, the newest first", () => {
  history.add("a", [speed(1)], [speed(2)]);
  history.add("b", [speed(3)], [speed(4), speed(5)]);
  history.undo();
  history.undo();
  expect(sent).toEqual([speed(3), speed(1)]);
  expect([history.canUndo.value, history.canRedo.value]).toEqual([false, true]);
  history.undo();
  history.redo();
  history.redo();
  expect(sent.slice(2)).toEqual([speed(2), speed(4), speed(5)]);
  expect([history.canUndo.value, history.canRedo.value]).toEqual([true, false]);
});

test("the movement of a slider is one change; another key or a pause starts a new one", () => {
  for (let i = 1; i <= 5; i++) {
    now += 100;
    history.add("window", [speed(i - 1)], [speed(i)]);
  }
  history.undo();
  expect(sent).toEqual([speed(0)]);
  history.redo();
  expect(sent.at(-1)).toEqual(speed(5));
  // What was taken back and done again is finished.
  history.add("window", [speed(5)], [speed(6)]);
  now += 1000;
  history.add("window", [speed(6)], [speed(7)]);
  history.add("other", [speed(8)], [speed(9)]);
  sent = [];
  while (history.canUndo.value) history.undo();
  expect(sent).toEqual([speed(8), speed(6), speed(5), speed(0)]);
});

test("a new change clears the redo list", () => {
  history.add("a", [speed(1)], [speed(2)]);
  history.undo();
  history.add("b", [speed(3)], [speed(4)]);
  expect(history.canRedo.value).toBe(false);
  const version = history.version.value;
  history.clear();
  expect(history.canUndo.value).toBe(false);
  history.undo();
  expect(history.version.value).toBe(version);
});

test("only the last two hundred are kept", () => {
  for (let i = 0; i < 300; i++) history.add(String(i), [speed(i)], [speed(i)]);
  while (history.canUndo.value) history.undo();
  expect(sent.length).toBe(200);
  expect(sent.at(-1)).toEqual(speed(100));
});
