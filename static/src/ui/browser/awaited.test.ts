import { afterEach, beforeEach, expect, test, vi } from "vitest";

/** Ends the probes, the oldest first. */
let probes: ((answer: Response) => void)[];

/** The module as it is when a page is opened: that of other tests counts their requests. */
let page: typeof import("./awaited");

beforeEach(async () => {
  vi.resetModules();
  page = await import("./awaited");
  vi.useFakeTimers();
  probes = [];
  vi.stubGlobal("fetch", () => new Promise<Response>((resolve) => probes.push(resolve)));
});

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

test("a server that answers nothing for two seconds has stalled until it answers", async () => {
  let answer: (value: string) => void = () => undefined;
  const request = page.awaited(new Promise<string>((resolve) => (answer = resolve)));
  await vi.advanceTimersByTimeAsync(1900);
  expect([probes.length, page.isStalled.value]).toEqual([1, false]);
  await vi.advanceTimersByTimeAsync(200);
  expect([probes.length, page.isStalled.value, page.hasStalled.value]).toEqual([1, true, true]);
  page.countSayers(1);
  expect(page.hasStalled.value).toBe(false);
  page.countSayers(-1);
  probes[0]?.(new Response());
  await vi.advanceTimersByTimeAsync(0);
  expect(page.isStalled.value).toBe(false);
  // the request itself takes long, and the server answers meanwhile
  await vi.advanceTimersByTimeAsync(1000);
  probes[1]?.(new Response());
  await vi.advanceTimersByTimeAsync(1000);
  expect([probes.length, page.isStalled.value]).toEqual([3, false]);
  answer("late");
  expect(await request).toBe("late");
  await vi.advanceTimersByTimeAsync(5000);
  expect([probes.length, page.isStalled.value]).toEqual([3, false]);
});

test("a request that is given up, or fails, is not waited for", async () => {
  const request = page.awaited(new Promise((_, reject) => setTimeout(() => reject(new Error("given up")), 2500)));
  const rejected = expect(request).rejects.toThrow("given up");
  await vi.advanceTimersByTimeAsync(2100);
  expect(page.isStalled.value).toBe(true);
  await vi.advanceTimersByTimeAsync(500);
  await rejected;
  expect(page.isStalled.value).toBe(false);
});

test("requests that take all connections of the browser are no sign of a server that has stalled", async () => {
  for (let i = 0; i < 6; i++) void page.awaited(new Promise((resolve) => setTimeout(resolve, 4000)));
  await vi.advanceTimersByTimeAsync(3500);
  expect([probes.length, page.isStalled.value]).toEqual([0, false]);
  await vi.advanceTimersByTimeAsync(1000);
});

test("an effect that counts one which says so runs once", async () => {
  const { effect } = await import("@preact/signals");
  let runs = 0;
  const end = effect(() => {
    runs++;
    page.countSayers(1);
  });
  page.countSayers(1);
  expect(runs).toBe(1);
  end();
});
