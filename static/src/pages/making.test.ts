import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { followMaking, type Making, newName } from "./making";

beforeEach(() => {
  vi.useFakeTimers();
});

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it("shows the progress of what takes long, until it is stopped", async () => {
  const asked: string[] = [];
  let fraction = 0;
  vi.stubGlobal("fetch", async (url: string) => {
    asked.push(url);
    fraction += 0.25;
    return Response.json({ what: "Reading the log", fraction, elapsed_s: 1 });
  });
  const shown: (Making | null)[] = [];
  const stop = followMaking("mine", (making) => shown.push(making));
  await vi.advanceTimersByTimeAsync(250);
  expect(asked).toEqual([]); // what is quick shows nothing
  await vi.advanceTimersByTimeAsync(500);
  expect(new Set(asked)).toEqual(new Set(["/api/sessions/making/mine"]));
  expect(shown.map((making) => making?.fraction)).toEqual([0.25, 0.5]);
  stop();
  expect(shown.at(-1)).toBeNull();
  const before = asked.length;
  await vi.advanceTimersByTimeAsync(2000);
  expect(asked.length).toBe(before);
  expect(shown.at(-1)).toBeNull();
});

it("goes on where the session is not known yet, or the server does not answer", async () => {
  const answers = [
    () => Promise.reject(new TypeError("no answer")),
    () => Promise.resolve(new Response(null, { status: 204 })),
    () => Promise.resolve(Response.json({ what: null, fraction: null, elapsed_s: 2 })),
  ];
  vi.stubGlobal("fetch", () => (answers.length > 1 ? answers.shift() : answers[0])?.());
  const shown: (Making | null)[] = [];
  const stop = followMaking(newName(), (making) => shown.push(making));
  await vi.advanceTimersByTimeAsync(900);
  expect(shown).toEqual([{ what: null, fraction: null, elapsed_s: 2 }]);
  stop();
});
