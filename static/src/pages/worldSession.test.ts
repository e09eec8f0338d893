import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { createWorld, starting, worldSession } from "./worldSession";

vi.mock("../ui/browser/media", () => ({ reducedMotion: { peek: () => false } }));

beforeEach(() => {
  vi.useFakeTimers();
});

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it("tells how long a new world takes, from 0.3 s on", async () => {
  let answer: (response: Response) => void = () => undefined;
  vi.stubGlobal("fetch", () => new Promise<Response>((resolve) => (answer = resolve)));
  const made = createWorld();
  await vi.advanceTimersByTimeAsync(250);
  expect(starting.value).toBeNull();
  await vi.advanceTimersByTimeAsync(650);
  expect(starting.value?.fraction).toBeNull();
  expect(starting.value?.elapsed_s).toBeGreaterThanOrEqual(0.6);
  answer(Response.json({ id: "a" }));
  expect(await made).toBe("a");
  expect(starting.value).toBeNull();
});

it("shows nothing any more after a request that fails", async () => {
  vi.stubGlobal("fetch", async () => {
    await new Promise((resolve) => setTimeout(resolve, 1000));
    return Response.json({ message: "There are too many sessions." }, { status: 503 });
  });
  const made = expect(createWorld()).rejects.toThrow("There are too many sessions.");
  await vi.advanceTimersByTimeAsync(700);
  expect(starting.value).not.toBeNull();
  await vi.advanceTimersByTimeAsync(700);
  await made;
  expect(starting.value).toBeNull();
});

it("keeps the world of this tab while the server has no room to answer, and replaces one that has ended", async () => {
  const kept = { getItem: () => "mine", setItem: vi.fn() };
  vi.stubGlobal("sessionStorage", kept);
  vi.stubGlobal("fetch", () =>
    Promise.resolve(Response.json({ message: "Too many requests at once." }, { status: 429 })),
  );
  await expect(worldSession()).rejects.toThrow("Too many requests at once.");
  expect(kept.setItem).not.toHaveBeenCalled();
  vi.stubGlobal("fetch", (address: string) =>
    Promise.resolve(
      address === "/api/sessions" ? Response.json({ id: "new" }, { status: 201 }) : new Response(null, { status: 404 }),
    ),
  );
  expect(await worldSession()).toBe("new");
  expect(kept.setItem).toHaveBeenCalledWith("gridbloom.world", "new");
});
