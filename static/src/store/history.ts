/** The user's changes, as commands to undo and to redo them. */

import { batch, computed, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import type { Command } from "../wire/protocol";

/** Changes with the same key within this time are merged, such as those of a slider or a dragged robot. */
const MERGE_MS = 700;
const MOST = 200;

interface Change {
  /** Identifies what was changed; changes with the same key in quick succession are merged. */
  readonly key: string;
  readonly undo: readonly Command[];
  readonly redo: readonly Command[];
  readonly at: number;
}

export class History {
  readonly canUndo: ReadonlySignal<boolean>;
  readonly canRedo: ReadonlySignal<boolean>;
  /** Incremented with every change, also by undo and redo. */
  readonly version = signal(0);
  readonly #done = signal<readonly Change[]>([]);
  readonly #undone = signal<readonly Change[]>([]);
  readonly #perform: (command: Command) => void;
  readonly #now: () => number;

  constructor(perform: (command: Command) => void, now: () => number = () => performance.now()) {
    this.#perform = perform;
    this.#now = now;
    this.canUndo = computed(() => this.#done.value.length > 0);
    this.canRedo = computed(() => this.#undone.value.length > 0);
  }

  /** Add a change that was just made. */
  add(key: string, undo: readonly Command[], redo: readonly Command[]): void {
    const at = this.#now();
    const before = this.#done.peek();
    const last = before.at(-1);
    const merges = last !== undefined && last.key === key && at - last.at < MERGE_MS;
    batch(() => {
      this.#done.value = [
        ...(merges ? before.slice(0, -1) : before),
        { key, undo: merges ? last.undo : undo, redo, at },
      ].slice(-MOST);
      this.#undone.value = [];
      this.version.value++;
    });
  }

  undo(): void {
    this.#move(this.#done, this.#undone, (change) => change.undo);
  }

  redo(): void {
    this.#move(this.#undone, this.#done, (change) => change.redo);
  }

  /** Remove all changes, for another session. */
  clear(): void {
    this.#done.value = this.#undone.value = [];
  }

  #move(
    from: Signal<readonly Change[]>,
    to: Signal<readonly Change[]>,
    commands: (change: Change) => readonly Command[],
  ): void {
    const change = from.peek().at(-1);
    if (!change) return;
    batch(() => {
      from.value = from.peek().slice(0, -1);
      to.value = [...to.peek(), { ...change, at: Number.NEGATIVE_INFINITY }];
      this.version.value++;
      for (const command of commands(change)) this.#perform(command);
    });
  }
}
