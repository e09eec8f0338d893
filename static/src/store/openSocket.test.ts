import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { CONNECT_MS, openSocket } from "./openSocket";

class FakeSocket extends EventTarget {
  readonly close = vi.fn(() => this.dispatchEvent(new Event("close")));
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("WebSocket", FakeSocket);
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("a connection that is not accepted is closed after a while, another one never", () => {
  const [silent, accepted, refused] = [0, 1, 2].map(() => openSocket("ws://server/stream", "v3"));
  accepted?.dispatchEvent(new Event("open"));
  refused?.dispatchEvent(new Event("close"));
  vi.advanceTimersByTime(CONNECT_MS - 1);
  expect(silent?.close).not.toHaveBeenCalled();
  vi.advanceTimersByTime(10 * CONNECT_MS);
  expect([silent, accepted, refused].map((one) => vi.mocked(one?.close ?? vi.fn()).mock.calls.length)).toEqual([
    1, 0, 0,
  ]);
});
