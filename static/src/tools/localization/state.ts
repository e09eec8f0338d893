/** The requested particle filter in the lab, and commands to start and change it. */

import { signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { Command, LocalizationMessage, Values } from "../../wire/protocol";

type LocalizeCommand = Extract<Command, { type: "localize" }>;

/** Maximum number of commands whose answers are awaited. */
const MOST_SENT = 200;

const written = (values: Values, map: string): string => JSON.stringify([Object.entries(values).sort(), map]);

/** Settings, shown at once. Answers to the page's own commands change nothing; changes by others are applied. */
export class FilterSettings {
  /** Parameters that differ from the defaults. */
  readonly values = signal<Values>({});
  readonly map = signal("plan");
  #sent: string[] = [];

  /** Record a sent command. */
  note({ values = {}, map = "plan" }: LocalizeCommand): void {
    this.values.value = values;
    this.map.value = map;
    this.#sent = [...this.#sent, written(values, map)].slice(-MOST_SENT);
  }

  take({ is_on, values, map }: LocalizationMessage): void {
    if (!is_on) return;
    const answered = this.#sent.lastIndexOf(written(values, map));
    if (answered >= 0) {
      this.#sent = this.#sent.slice(answered);
      return;
    }
    this.#sent = [];
    this.values.value = values;
    this.map.value = map;
  }
}

class FilterState extends FilterSettings {
  readonly #store: Store;

  constructor(store: Store) {
    super();
    this.#store = store;
    store.part("localization").message.subscribe((message) => message && this.take(message));
    store.hears("localize", (command) => this.note(command as LocalizeCommand));
  }

  /** Begin to localize the lab's robot, from an unknown pose. */
  begin(values: Values, map: string): void {
    const command = { type: "localize", value: true, values, map } as const;
    this.note(command);
    this.#store.send(command);
  }

  /** Set parameters of the filter; a running one continues with them. */
  set(values: Values): void {
    const [old, map] = [this.values.peek(), this.map.peek()];
    const next = { ...old, ...values };
    if (this.#store.part("localization").message.peek()?.is_on !== true) {
      this.values.value = next;
      return;
    }
    const command = { type: "localize", value: true, map, keep: true } as const;
    this.#store.change(
      `localize ${Object.keys(values).join(" ")}`,
      [{ ...command, values: old }],
      [{ ...command, values: next }],
    );
  }
}

export const filterOf = (store: Store): FilterState => store.of(FilterState);
