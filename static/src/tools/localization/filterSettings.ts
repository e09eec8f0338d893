/** What the user wants of the lab's particle filter: its parameters, and the map that it is given. */

import { signal } from "@preact/signals";
import type { Command, LocalizationMessage, Values } from "../../wire/protocol";

export type LocalizeCommand = Extract<Command, { type: "localize" }>;

/** Most commands whose answers are awaited. */
const MOST_SENT = 200;

const written = (values: Values, map: string): string => JSON.stringify([Object.entries(values).sort(), map]);

/** Shown at once; answers to one's own commands change nothing, and what others set is taken over. */
export class FilterSettings {
  /** Parameters that differ from the first ones. */
  readonly values = signal<Values>({});
  readonly map = signal("plan");
  #sent: string[] = [];

  /** Note a command that is sent. */
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
