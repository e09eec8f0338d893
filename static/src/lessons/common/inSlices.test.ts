// @vitest-environment happy-dom
import { expect, test, vi } from "vitest";
import { inSlices } from "./inSlices";

test("for paper all pieces are done before it returns, and shown once", () => {
  let left = 5;
  const shown: number[] = [];
  inSlices(
    true,
    () => --left > 0,
    () => shown.push(left),
  );
  expect(shown).toEqual([0]);
});

test("on the screen nothing is done before the page has no input, and nothing after it is stopped", async () => {
  vi.useFakeTimers();
  let done = 0;
  const piece = (): boolean => ++done < 3;
  const stop = inSlices(false, piece, () => undefined);
  expect(done).toBe(0);
  await vi.runAllTimersAsync();
  expect(done).toBe(3);
  stop();
  done = 0;
  inSlices(false, piece, () => undefined)();
  await vi.runAllTimersAsync();
  expect(done).toBe(0);
  vi.useRealTimers();
});
