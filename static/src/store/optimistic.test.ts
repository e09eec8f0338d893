import { effect } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import type { Command, Hello, ServerMessage, Value } from "../wire/protocol";
import { Optimistic } from "./optimistic";
import { Outbox } from "./sessionSignals";
import { Store } from "./store";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

describe("values that are set locally", () => {
  let values: Optimistic;
  beforeEach(() => {
    values = new Optimistic();
    values.update({ hit: 1, miss: -1 });
  });

  test("are displayed at once, and older messages do not overwrite them", () => {
    values.set("hit", 2);
    expect(values.values.value).toEqual({ hit: 2, miss: -1 });
    values.set("hit", 3);
    values.update({ hit: 1, miss: -0.5 }); // about another value
    values.update({ hit: 2, miss: -0.5 });
    expect(values.values.value).toEqual({ hit: 3, miss: -0.5 });
    values.update({ hit: 3, miss: -0.5 });
    expect(values.pending()).toEqual({});
    values.update({ hit: 2, miss: -0.5 }); // somebody else, later
    expect(values.values.value.hit).toBe(2);
  });

  test("are kept while the user goes back and forth, though older answers have the same value", () => {
    const seen: unknown[] = [];
    for (const value of [2, 3, 2]) values.set("hit", value);
    effect(() => void seen.push(values.values.value.hit));
    for (const hit of [2, 3, 2]) values.update({ hit, miss: -1 });
    expect(seen).toEqual([2]);
    expect(values.pending()).toEqual({});
    for (const value of [5, 2, 6]) values.set("hit", value);
    values.update({ hit: 2, miss: -0.5 }); // still the previous value
    for (const hit of [5, 2, 6]) values.update({ hit, miss: -0.5 });
    expect(seen).toEqual([2, 5, 2, 6, 6]); // as set here, and once more for the other value
  });

  test("are discarded after a while if several were answered as one", () => {
    for (const value of [2, 1]) values.set("hit", value); // the server, which received both at once, sends nothing
    expect(values.pending()).toEqual({ hit: 1 });
    vi.advanceTimersByTime(60_000);
    expect(values.pending()).toEqual({});
    values.update({ hit: 2, miss: -1 }); // somebody else
    expect(values.values.value.hit).toBe(2);
    values.set("hit", 2);
    expect(values.pending()).toEqual({}); // as it is: nothing to wait for
  });

  test("are replaced by a value that was not set here, and by a refusal", () => {
    values.set("hit", 9);
    values.update({ hit: 4, miss: -1 });
    expect(values.values.value.hit).toBe(4);
    values.set("hit", 9);
    values.refuse();
    expect(values.values.value.hit).toBe(4);
  });

  test("are kept at a new connection until it confirms them", () => {
    for (const value of [7, 8, 9]) values.set("hit", value);
    values.reconnected({ hit: 0.85, miss: -1 }); // the server began again
    vi.advanceTimersByTime(60_000);
    expect(values.values.value.hit).toBe(9);
    expect(values.pending()).toEqual({ hit: 9 });
    values.update({ hit: 9, miss: -1 });
    expect(values.pending()).toEqual({});
  });

  test("an unchanged value is no change", () => {
    const seen: unknown[] = [];
    effect(() => void seen.push(values.values.value));
    values.set("hit", 2);
    expect(values.update({ hit: 2, miss: -1 })).toBe(true);
    expect(values.update({ miss: -1, hit: 2 })).toBe(false);
    expect(seen).toEqual([
      { hit: 1, miss: -1 },
      { hit: 2, miss: -1 },
    ]);
  });
});

/** How long the server takes to answer, in milliseconds. */
const SLOW = 5000;

/** A store, and a server that carries out each command after SLOW and sends the values, as in the protocol. */
function slowServer(judge: (value: number) => number | null) {
  let held: Record<string, Value> = { hit: 1, miss: -1 };
  let faults: Record<string, Value> = { drift: false };
  const answer = (): ServerMessage => ({
    type: "parameters",
    values: { ...held },
    sensor: null,
    faults: { ...faults },
  });
  const carryOut = (command: Command): void => {
    if (command.type === "faults") {
      faults = { ...faults, ...command.values };
      store.receive(answer());
    } else if (command.type === "parameters") {
      const wanted = Object.entries(command.values).map(([name, value]) => [name, judge(Number(value))] as const);
      if (wanted.some(([, value]) => value === null)) {
        store.receive(answer());
        store.receive({ type: "error", code: "parameter.hit", message: "hit is out of range." });
        return;
      }
      const next = { ...held, ...Object.fromEntries(wanted as [string, number][]) };
      const isNews = JSON.stringify(next) !== JSON.stringify(held);
      held = next;
      if (isNews) store.receive(answer());
    }
  };
  const send = (command: Command): boolean => {
    setTimeout(() => carryOut(command), SLOW);
    return true;
  };
  const store: Store = new Store(send, new Outbox(send, (task) => void setTimeout(task, 16)));
  const hello: Hello = {
    type: "hello",
    protocol: "gridbloom.v3",
    session: "s",
    kind: "simulation",
    title: "t",
    epoch_id: "a",
    speeds: [1, 1],
    parameters: { table: [], values: held },
    sensor: null,
    log: null,
    tables: {},
  };
  store.receive(hello);
  store.receive(answer());
  const seen: unknown[] = [];
  effect(() => void seen.push(store.mapping.values.value.hit));
  return { store, seen, held: () => held };
}

/** Drag over values, one in each animation frame and one of them for long. */
function drag(store: Store, values: readonly number[]): void {
  for (const value of values) {
    store.setParameter("hit", value);
    vi.advanceTimersByTime(20);
  }
}

describe("a server that answers after five seconds", () => {
  test("does not overwrite what was set locally", () => {
    const { store, seen, held } = slowServer((value) => value);
    const way = [2, 3, 4, 3, 2, 5];
    drag(store, way);
    vi.advanceTimersByTime(3 * SLOW);
    expect(seen).toEqual([1, ...way]);
    expect(held().hit).toBe(5);
    expect(store.mapping.pending()).toEqual({});
  });

  test("nor a switch that was turned while a slider moved", () => {
    const { store } = slowServer((value) => value);
    const seen: unknown[] = [];
    effect(() => void seen.push(store.faults.value?.drift));
    drag(store, [2, 3]);
    store.setTogether("drift", {}, { drift: true });
    drag(store, [4]);
    vi.advanceTimersByTime(3 * SLOW);
    expect(seen).toEqual([false, true]);
  });

  test("nor what is undone while it is under way", () => {
    const { store, seen, held } = slowServer((value) => value);
    drag(store, [2]);
    store.history.undo();
    vi.advanceTimersByTime(3 * SLOW);
    expect(seen).toEqual([1, 2, 1]);
    expect(held().hit).toBe(1);
  });

  test("overrides the local value if it refuses", () => {
    const { store, seen } = slowServer((value) => (value > 3 ? null : value));
    drag(store, [2, 9]);
    vi.advanceTimersByTime(3 * SLOW);
    expect(seen).toEqual([1, 2, 9, 2]);
    expect(store.notice.value?.kind).toBe("error");
  });

  test("overrides the local value if it clamps", () => {
    const { store, seen } = slowServer((value) => Math.min(value, 4));
    drag(store, [8, 9]);
    vi.advanceTimersByTime(3 * SLOW);
    expect(seen).toEqual([1, 8, 9, 4]);
    expect(store.mapping.pending()).toEqual({});
  });
});
