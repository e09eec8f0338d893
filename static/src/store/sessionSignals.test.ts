import { expect, test } from "vitest";
import type { Command } from "../wire/protocol";
import { Outbox } from "./sessionSignals";

test("of requests about two layers the newest of each is sent", () => {
  const sent: Command[] = [];
  const tasks: (() => void)[] = [];
  const outbox = new Outbox(
    (command) => sent.push(command),
    (task) => tasks.push(task),
  );
  for (const row of [1, 2]) {
    outbox.put({ type: "inspect", row, col: 0, epoch: 1 });
    outbox.put({ type: "inspect", row: 10 * row, col: 0, epoch: 4, layer: "second_map" });
  }
  for (const task of tasks) task();
  expect(sent).toEqual([
    { type: "inspect", row: 2, col: 0, epoch: 1 },
    { type: "inspect", row: 20, col: 0, epoch: 4, layer: "second_map" },
  ]);
});
