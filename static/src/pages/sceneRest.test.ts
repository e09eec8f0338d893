import { expect, test, vi } from "vitest";
import { HEARTBEAT_MS, intervalUntilRest, SceneRest } from "./sceneRest";

test("frames of the client end some seconds after the last change, and begin again with the next one", () => {
  vi.useFakeTimers();
  const rest = new SceneRest();
  const every = intervalUntilRest(
    (task, period) => Number(setInterval(task, period)),
    () => rest.isAtRest(performance.now()),
  );
  const [frame, other] = [vi.fn(), vi.fn()];
  rest.changed(performance.now());
  every(frame, HEARTBEAT_MS);
  every(other, 500);
  vi.advanceTimersByTime(5000);
  expect(frame).toHaveBeenCalledTimes(5);
  vi.advanceTimersByTime(55_000);
  expect(frame).toHaveBeenCalledTimes(10);
  expect(other).toHaveBeenCalledTimes(120);
  rest.changed(performance.now());
  vi.advanceTimersByTime(2000);
  expect(frame).toHaveBeenCalledTimes(12);
  vi.useRealTimers();
});
