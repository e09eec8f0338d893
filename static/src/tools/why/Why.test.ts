import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Store } from "../../store/store";
import type { Command, Frame, Geometry, WhyMessage } from "../../wire/protocol";
import { pollWhy } from "./Why";

const GEOMETRY: Geometry = {
  type: "geometry",
  layer: 1,
  epoch: 1,
  resolution: 0.1,
  rows: 64,
  cols: 64,
  origin: [0, 0, 0],
  low: -2,
  high: 3.5,
  tile: 64,
};

let store: Store;
let sent: Extract<Command, { type: "why" }>[];
let stop: () => void;

const frame = (index: number): void => store.receive({ type: "frame", index, ranges: [] } as unknown as Frame);
const answer = (more: Partial<WhyMessage> = {}): void =>
  store.receive({
    ...{ type: "why", row: 5, col: 12, epoch: 1, layer: "map", total: 1000, contributions: [] },
    ...more,
  } as unknown as WhyMessage);

/** Let time pass in steps of an animation frame or so. */
function pass(ms: number, each: (i: number) => void = () => undefined): void {
  for (let i = 0; i < ms / 33; i++) {
    each(i);
    vi.advanceTimersByTime(33);
  }
}

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  store = new Store((command) => {
    if (command.type === "why") sent.push(command);
    return true;
  });
  const info = { id: 1, name: "map", kind: "grid", title: "Map", style: "belief", columns: [] } as const;
  store.receive({ type: "layers", layers: [info] });
  store.receive(GEOMETRY);
  stop = pollWhy(store);
});

afterEach(() => {
  stop();
  vi.useRealTimers();
});

test("a cell is requested at once, and not again while nothing changes", () => {
  pass(1000);
  expect(sent).toEqual([]);
  store.explain([1.25, 0.55]);
  pass(5000);
  expect(sent).toEqual([{ type: "why", row: 5, col: 12, epoch: 1, layer: "map" }]);
});

test("while the robot drives once a second, while parameters change at most three times", () => {
  store.explain([1.25, 0.55]);
  pass(200);
  sent = [];
  pass(3000, frame);
  expect(sent.length).toBeGreaterThanOrEqual(2);
  expect(sent.length).toBeLessThanOrEqual(3);
  sent = [];
  pass(3000, (i) => store.mapping.update({ log_odds_hit: i }));
  expect(sent.length).toBeGreaterThanOrEqual(7);
  expect(sent.length).toBeLessThanOrEqual(9);
});

test("an older update is requested with its window, another cell with a new request", () => {
  store.explain([1.25, 0.55]);
  pass(200);
  answer();
  store.selectedUpdate.value = 42;
  pass(200);
  expect(sent.at(-1)).toEqual({ type: "why", row: 5, col: 12, epoch: 1, layer: "map", until: 200 });
  store.explain([1.25, 0.65]);
  pass(200);
  expect(store.why.value).toBeNull();
  expect(sent.at(-1)).toEqual({ type: "why", row: 6, col: 12, epoch: 1, layer: "map" });
  answer(); // late, about the cell before
  expect(store.why.value).toBeNull();
  answer({ row: 6 });
  expect(store.why.value?.row).toBe(6);
});

test("no query is sent once the panel is closed", () => {
  store.explain([1.25, 0.55]);
  pass(200);
  store.explain(null);
  sent = [];
  pass(3000, frame);
  expect(sent).toEqual([]);
  expect(store.why.value).toBeNull();
});
