import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { Value, Values } from "../wire/protocol";

/** Once a local value has agreed with the server's for this time, no older answer is expected. */
const AGREED_MS = 30_000;

interface Local {
  readonly value: Value;
  /** The values set locally that the server may still confirm, oldest first; `value` is the last of them. */
  readonly unanswered: readonly Value[];
}

const isSame = (a: Values, b: Values): boolean => {
  const names = Object.keys(a);
  return names.length === Object.keys(b).length && names.every((name) => name in b && Object.is(a[name], b[name]));
};

/**
 * Values that the server owns and the user changes. A value that is set locally is displayed at once, and older
 * messages of a slow server do not overwrite it: they contain a value that was set here before, or the one preceding
 * it. The server confirms values in the order in which they were set, but may skip some, because it uses only the
 * newest of several waiting values. A value that was not set here is a change by the server, which is displayed at
 * once; so is a refusal.
 */
export class Optimistic {
  readonly values: ReadonlySignal<Values>;
  readonly #server = signal<Values>({});
  readonly #local = signal<ReadonlyMap<string, Local>>(new Map());
  readonly #later: (task: () => void, ms: number) => void;

  constructor(later: (task: () => void, ms: number) => void = (task, ms) => void setTimeout(task, ms)) {
    this.#later = later;
    let last: Values = {};
    this.values = computed(() => {
      const values: Record<string, Value> = { ...this.#server.value };
      for (const [name, { value }] of this.#local.value) values[name] = value;
      // The same object if nothing changed, so that dependent values are not computed again.
      if (!isSame(values, last)) last = values;
      return last;
    });
  }

  /** Set a value locally. */
  set(name: string, value: Value): void {
    const before = this.#local.peek().get(name)?.unanswered ?? [];
    if (before.length === 0 && this.#server.peek()[name] === value) return;
    const unanswered = before.at(-1) === value ? before : [...before, value];
    this.#local.value = new Map(this.#local.peek()).set(name, { value, unanswered });
    if (this.#server.peek()[name] === value) this.#agree(name);
  }

  /** The values that the server has not confirmed yet. */
  pending(): Values {
    return Object.fromEntries([...this.#local.peek()].map(([name, { value }]) => [name, value]));
  }

  /** Set the server's values; returns whether they differ from its previous ones. */
  update(values: Values): boolean {
    const before = this.#server.peek();
    this.#server.value = values;
    const agreed: string[] = [];
    const remaining = new Map<string, Local>();
    for (const [name, local] of this.#local.peek()) {
      const received = values[name];
      // An unchanged value, because the message concerns another one.
      const answered = received === undefined || received === before[name] ? -1 : local.unanswered.indexOf(received);
      if (answered < 0 && received !== before[name]) continue;
      const unanswered = local.unanswered.slice(answered + 1);
      if (unanswered.length === 0) continue;
      remaining.set(name, { value: local.value, unanswered });
      if (received === local.value) agreed.push(name);
    }
    if (this.#local.peek().size > 0) this.#local.value = remaining;
    for (const name of agreed) this.#agree(name);
    return !isSame(values, before);
  }

  /** Set the server's values at a new connection. Local values are kept, and the caller sends them again. */
  reconnected(values: Values): void {
    this.#server.value = values;
    const remaining = [...this.#local.peek()].map(
      ([name, { value }]) => [name, { value, unanswered: [value] }] as const,
    );
    this.#local.value = new Map(remaining);
  }

  /** The server refused a value: discard all local ones. */
  refuse(): void {
    if (this.#local.peek().size > 0) this.#local.value = new Map();
  }

  /** The server's value agrees with the local one, but older answers may still arrive if values were repeated. */
  #agree(name: string): void {
    const local = this.#local.peek().get(name);
    this.#later(() => {
      const now = this.#local.peek();
      if (!local || now.get(name) !== local || this.#server.peek()[name] !== local.value) return;
      this.#local.value = new Map([...now].filter(([other]) => other !== name));
    }, AGREED_MS);
  }
}
