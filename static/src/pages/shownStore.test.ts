import { signal } from "@preact/signals";
import { beforeEach, expect, it, vi } from "vitest";
import { stateAt } from "../grid/cellValues";
import { FIRST_SEED, firstPicture } from "../store/firstPicture";
import FIRST from "../store/firstPicture.json";
import { Store } from "../store/store";
import { decodeFrame } from "../wire/decodeFrame";
import type { Command, ServerMessage } from "../wire/protocol";
import { shownStore } from "./shownStore";
import { createWorld } from "./worldSession";

vi.mock("../ui/browser/media", () => ({ reducedMotion: { peek: () => false, value: false } }));

beforeEach(() => {
  vi.stubGlobal("requestAnimationFrame", () => 0);
  return () => vi.unstubAllGlobals();
});

/** What a session sends. */
function receiveAll(store: Store): void {
  for (const message of FIRST.messages) store.receive(message as unknown as ServerMessage);
  store.take(decodeFrame(Uint8Array.from(atob(FIRST.tiles), (byte) => byte.charCodeAt(0)).buffer));
}

it("has the world, the robot, its scan and a map in the first picture", () => {
  const first = firstPicture();
  expect(first.world.value?.polygons.length).toBeGreaterThan(5);
  expect(first.frame.value?.ranges.length).toBeGreaterThan(100);
  const [x, y] = first.frame.value?.pose ?? [0, 0];
  const cell = first.cellOf([x, y]);
  const map = first.map.value;
  expect(cell && map && stateAt(map.cells.at(cell.row, cell.col), map.geometry)).toBe("free");
});

it("is followed by a world of the same seed", async () => {
  const sent: unknown[] = [];
  vi.stubGlobal("fetch", async (_: string, { body }: { body: string }) => {
    sent.push(JSON.parse(body));
    return Response.json({ id: "a" });
  });
  await createWorld();
  expect(sent).toEqual([{ kind: "simulation", playing: true, seed: FIRST_SEED }]);
});

it("gives way to the live world once that has a map, and sends the robot where the user has clicked", async () => {
  const first = firstPicture();
  const live = signal<Store | null>(null);
  const shown = shownStore(live, first);
  expect(shown.value).toBe(first);
  first.teleport([3, 4]);
  const sent: Command[] = [];
  const store = new Store((command) => {
    sent.push(command);
    return true;
  });
  live.value = store;
  expect(shown.value).toBe(first);
  store.receive(FIRST.messages.find(({ type }) => type === "frame") as unknown as ServerMessage);
  expect(shown.value === first).toBe(true); // it has no map yet
  receiveAll(store);
  expect(shown.value === store).toBe(true);
  await Promise.resolve();
  expect(sent).toMatchObject([{ type: "teleport", x: 3, y: 4 }]);
  // A session that takes its place is shown from its start.
  live.value = new Store(() => true);
  expect(shown.value).toBe(live.value);
});

it("shows the live world at once if there is no first picture", () => {
  const live = signal<Store | null>(null);
  const shown = shownStore(live, null);
  expect(shown.value).toBeNull();
  live.value = new Store(() => true);
  expect(shown.value).toBe(live.value);
});
