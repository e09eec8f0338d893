// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Store } from "../../../store/store";
import { PoseCorrection } from "../slam/poseCorrection";
import { Localizing } from "./localizing";

const MAP = { title: "drive.log, scan", rows: 2, cols: 3, resolution: 0.05, origin: [0, 0, 0], notes: [] };

/** Requests that are under way, by method and the end of the address; each is answered with a value. */
let open: Map<string, (answer: unknown, status?: number) => void>;

beforeEach(() => {
  vi.useFakeTimers();
  open = new Map();
  vi.stubGlobal("fetch", (url: string, options?: RequestInit) => {
    const name = `${options?.method ?? "GET"} ${url.slice(url.lastIndexOf("/") + 1)}`;
    return new Promise<Response>((resolve) => {
      open.set(name, (answer, status = 200) => {
        open.delete(name);
        resolve(Response.json(answer, { status }));
      });
    });
  });
});

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

async function answer(name: string, value: unknown, status = 200): Promise<void> {
  const give = open.get(name);
  if (!give) throw new Error(`${name} was not asked for, but ${[...open.keys()].join(", ")}`);
  give(value, status);
  await vi.advanceTimersByTimeAsync(0);
}

const refuse = (name: string): Promise<void> => answer(name, { code: "busy", message: "Later." }, 503);

const job = (state: string) => ({ state, fraction: 0, parameters: {}, result: null });

it("keeps the map that was chosen while the earlier one was asked for", async () => {
  const localizing = new Localizing(new Store(() => true), "s");
  const loaded = localizing.loadMap();
  const chosen = localizing.chooseLog("log", null, null);
  await answer("PUT map", { map: MAP });
  await chosen;
  await answer("GET map", { map: null }); // what the server knew before
  await loaded;
  expect(localizing.map.value).toEqual(MAP);
});

it("shows the map that was chosen on an earlier visit", async () => {
  const localizing = new Localizing(new Store(() => true), "s");
  const loaded = localizing.loadMap();
  await answer("GET map", { map: MAP });
  await loaded;
  expect(localizing.map.value).toEqual(MAP);
});

it("asks for the map again, while the group is open, until the server answers", async () => {
  const localizing = new Localizing(new Store(() => true), "s");
  const hide = localizing.show();
  void localizing.loadMap();
  await refuse("GET map");
  expect(open.has("GET map")).toBe(false);
  await vi.advanceTimersByTimeAsync(3000);
  await refuse("GET map");
  await vi.advanceTimersByTimeAsync(3000);
  await answer("GET map", { map: MAP });
  expect(localizing.map.value).toEqual(MAP);
  localizing.map.value = null;
  void localizing.loadMap();
  hide();
  await refuse("GET map");
  await vi.advanceTimersByTimeAsync(3000);
  expect(open.has("GET map")).toBe(false);
});

it.each([
  { name: "localization", jobs: () => new Localizing(new Store(() => true), "s") },
  { name: "heal", jobs: () => new PoseCorrection(new Store(() => true), "s") },
])("follows a job ($name) that was begun while its state was asked for", async ({ name, jobs }) => {
  const followed = jobs();
  const looked = followed.look();
  const begun = followed.begin(null);
  await answer(`POST ${name}`, job("queued"));
  await begun;
  await answer(`GET ${name}`, job("none")); // the state before
  await looked;
  expect(followed.job.value?.state).toBe("queued");
  await vi.advanceTimersByTimeAsync(500);
  await answer(`GET ${name}`, job("running"));
  expect(followed.job.value?.state).toBe("running");
  followed.stop();
});
