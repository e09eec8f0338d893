// @vitest-environment happy-dom
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Store } from "../../store/store";
import type { Command, CostmapMessage, Frame, PathMessage } from "../../wire/protocol";
import { costmapOf } from "./state";
import { WhyCost } from "./WhyCost";

let store: Store;
let questions: Command[];

const frame = (index: number): void => store.receive({ type: "frame", index, ranges: [] } as unknown as Frame);
const costmap = (): void => store.receive({ type: "costmap", is_on: true, values: {} } as CostmapMessage);
const path = (): void => store.receive({ type: "path", goal: null } as PathMessage);

/** Let a second pass after each of some changes; return how many questions each of them led to. */
const asked = async (...changes: (() => void)[]): Promise<number[]> => {
  const counts: number[] = [];
  for (const change of changes) {
    const before = questions.length;
    await act(async () => {
      change();
      await vi.advanceTimersByTimeAsync(1000);
    });
    counts.push(questions.length - before);
  }
  return counts;
};

beforeEach(() => {
  vi.useFakeTimers();
  questions = [];
  store = new Store((command) => {
    if (command.type === "cost") questions.push(command);
    return true;
  });
  costmap();
  frame(7);
});

afterEach(() => {
  render(null, document.body);
  vi.useRealTimers();
});

test("a cost is asked for again only when something that it depends on has changed", async () => {
  costmapOf(store).asked.value = [1, 2];
  expect(await asked(() => render(h(WhyCost, { store }), document.body))).toEqual([1]);
  const sameScan = (): void => frame(7);
  expect(await asked(sameScan, sameScan)).toEqual([0, 0]);
  expect(await asked(() => frame(8), costmap, path)).toEqual([1, 1, 1]);
});
