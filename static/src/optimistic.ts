import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { Value, Values } from "./protocol";

/** How long a value set here wins over what the server says, once it was set for the last time. */
const SETTLE_MS = 600;

interface Local {
  readonly value: Value;
  readonly since: number;
}

const isSame = (a: Values, b: Values): boolean => {
  const names = Object.keys(a);
  return names.length === Object.keys(b).length && names.every((name) => name in b && Object.is(a[name], b[name]));
};

/**
 * Values that the server owns and the hand moves. What is set here shows at once; the server's echo is older than the
 * hand while a slider moves, so it waits until it agrees, or until the hand has rested. A refusal gives way at once.
 */
export class Optimistic {
  readonly values: ReadonlySignal<Values>;
  readonly #server = signal<Values>({});
  readonly #local = signal<ReadonlyMap<string, Local>>(new Map());
  readonly #now: () => number;
  readonly #later: (task: () => void, ms: number) => void;
  #heardAt = Number.NEGATIVE_INFINITY;

  constructor(
    now: () => number = () => performance.now(),
    later: (task: () => void, ms: number) => void = (task, ms) => void setTimeout(task, ms),
  ) {
    this.#now = now;
    this.#later = later;
    let last: Values = {};
    this.values = computed(() => {
      const values: Record<string, Value> = { ...this.#server.value };
      for (const [name, { value }] of this.#local.value) values[name] = value;
      // An echo of what is there already is no change: nothing that hangs on the values begins anew for it.
      if (!isSame(values, last)) last = values;
      return last;
    });
  }

  /** The hand sets a value. */
  set(name: string, value: Value): void {
    const since = this.#now();
    this.#local.value = new Map(this.#local.peek()).set(name, { value, since });
    this.#later(() => {
      const local = this.#local.peek().get(name);
      // Without an answer since then (the server is away) the hand's value stays until there is one.
      if (local?.since === since && this.#heardAt > since) this.#drop((other) => other === name);
    }, SETTLE_MS);
  }

  /** What the server has not confirmed yet. */
  pending(): Values {
    return Object.fromEntries([...this.#local.peek()].map(([name, { value }]) => [name, value]));
  }

  /** The server says what holds. Says whether that is something else than what it said before. */
  hear(values: Values): boolean {
    const isNews = !isSame(values, this.#server.peek());
    this.#server.value = values;
    this.#heardAt = this.#now();
    this.#drop((name, local) => values[name] === local.value || this.#heardAt - local.since > SETTLE_MS);
    return isNews;
  }

  /** The server refused what was set here. */
  refuse(): void {
    this.#drop(() => true);
  }

  #drop(which: (name: string, local: Local) => boolean): void {
    const kept = [...this.#local.peek()].filter(([name, local]) => !which(name, local));
    if (kept.length !== this.#local.peek().size) this.#local.value = new Map(kept);
  }
}
