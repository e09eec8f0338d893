/** The particle filter that the user wants in the lab, and how it is begun and changed. */

import type { Store } from "../../store/store";
import type { Values } from "../../wire/protocol";
import { FilterSettings, type LocalizeCommand } from "./filterSettings";

class FilterState extends FilterSettings {
  readonly #store: Store;

  constructor(store: Store) {
    super();
    this.#store = store;
    store.part("localization").message.subscribe((message) => message && this.take(message));
    store.hears("localize", (command) => this.note(command as LocalizeCommand));
  }

  /** Begin to localize the lab's robot, from anywhere. */
  begin(values: Values, map: string): void {
    const command = { type: "localize", value: true, values, map } as const;
    this.note(command);
    this.#store.send(command);
  }

  /** Set parameters of the filter; one that runs goes on with them. */
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
