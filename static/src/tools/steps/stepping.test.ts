import { signal } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { Store } from "../../store/store";
import type { Frame, Geometry } from "../../wire/protocol";
import { step } from "./stepping";

const frame = { index: 5, ranges: [1], angle_min: 0, angle_increment: 0.1, range_max: 10 } as unknown as Frame;
const geometry = { resolution: 0.1, rows: 64, cols: 64, origin: [0, 0, 0] } as unknown as Geometry;
const values = { model: "fixed_increments", update: "per_beam", traversal: "bresenham", log_odds_prior: 0 };

function pausedStore() {
  const shown = signal(frame);
  return {
    mapping: { values: signal({ ...values, log_odds_hit: 0.85, log_odds_miss: -0.4, range_max: 10 }) },
    frame: shown,
    beliefFrame: shown,
    beliefPose: signal([3, 3, 0]),
    map: signal({ geometry }),
    playing: signal(false),
    stepping: signal<unknown>(null),
    notice: signal<unknown>(null),
    send: vi.fn(),
  };
}

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

test("a step is made when a slow server answers, and not when it refuses", async () => {
  const store = pausedStore();
  const back = step(store as unknown as Store, "cell", -1);
  await vi.advanceTimersByTimeAsync(30_000);
  expect(store.stepping.value).toBeNull();
  store.frame.value = { ...frame, index: 4 };
  await back;
  expect(store.stepping.value).toMatchObject({ index: 4 });
  expect(store.send).toHaveBeenCalledExactlyOnceWith({ type: "step", scans: -1 });

  const other = pausedStore();
  const refused = step(other as unknown as Store, "cell", 1);
  other.notice.value = { kind: "error", code: "command.scans", message: "No." };
  await refused;
  expect(other.stepping.value).toBeNull();
  void step(other as unknown as Store, "cell", 1); // one that was refused does not hold up the next
  expect(other.send).toHaveBeenCalledTimes(2);
});
