import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { Value, Values } from "../wire/protocol";

/** When the server and the hand have said the same for so long, no older answer is under way any more. */
const AGREED_MS = 30_000;

interface Local {
  readonly value: Value;
  /** What was set here and may still be answered, the oldest first; `value` is the last of it. */
  readonly unanswered: readonly Value[];
}

const isSame = (a: Values, b: Values): boolean => {
  const names = Object.keys(a);
  return names.length === Object.keys(b).length && names.every((name) => name in b && Object.is(a[name], b[name]));
};

/**
 * Values that the server owns and the hand moves. What is set here shows at once, and however slow the server is, none of
 * its older words takes it back: each is known by being a value that was set here, or the one that held before. They are
 * answered in the order in which they were set, though not each: of several that wait the server takes the newest. A value
 * that nobody set here is the server's own word, and holds at once; so does a refusal.
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
      // An echo of what is there already is no change: nothing that hangs on the values begins anew for it.
      if (!isSame(values, last)) last = values;
      return last;
    });
  }

  /** The hand sets a value. */
  set(name: string, value: Value): void {
    const before = this.#local.peek().get(name)?.unanswered ?? [];
    if (before.length === 0 && this.#server.peek()[name] === value) return;
    const unanswered = before.at(-1) === value ? before : [...before, value];
    this.#local.value = new Map(this.#local.peek()).set(name, { value, unanswered });
    if (this.#server.peek()[name] === value) this.#agree(name);
  }

  /** What the server has not confirmed yet. */
  pending(): Values {
    return Object.fromEntries([...this.#local.peek()].map(([name, { value }]) => [name, value]));
  }

  /** The server says what holds. Says whether that is something else than what it said before. */
  hear(values: Values): boolean {
    const before = this.#server.peek();
    this.#server.value = values;
    const agreed: string[] = [];
    const kept = new Map<string, Local>();
    for (const [name, local] of this.#local.peek()) {
      const word = values[name];
      // The word that held before comes again when the message is about another value.
      const answered = word === undefined || word === before[name] ? -1 : local.unanswered.indexOf(word);
      if (answered < 0 && word !== before[name]) continue;
      const unanswered = local.unanswered.slice(answered + 1);
      if (unanswered.length === 0) continue;
      kept.set(name, { value: local.value, unanswered });
      if (word === local.value) agreed.push(name);
    }
    if (this.#local.peek().size > 0) this.#local.value = kept;
    for (const name of agreed) this.#agree(name);
    return !isSame(values, before);
  }

  /** A new connection says what holds: no answer to what was set here, which still stands and is to be sent anew. */
  greet(values: Values): void {
    this.#server.value = values;
    const standing = [...this.#local.peek()].map(
      ([name, { value }]) => [name, { value, unanswered: [value] }] as const,
    );
    this.#local.value = new Map(standing);
  }

  /** The server refused what was set here. */
  refuse(): void {
    if (this.#local.peek().size > 0) this.#local.value = new Map();
  }

  /** Server and hand say the same, but older answers may be under way: the hand goes back and forth. */
  #agree(name: string): void {
    const local = this.#local.peek().get(name);
    this.#later(() => {
      const now = this.#local.peek();
      if (!local || now.get(name) !== local || this.#server.peek()[name] !== local.value) return;
      this.#local.value = new Map([...now].filter(([other]) => other !== name));
    }, AGREED_MS);
  }
}
