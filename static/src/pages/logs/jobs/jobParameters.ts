/** The parameters that a visitor has set for the next SLAM or localization of a log. */

import { signal } from "@preact/signals";
import type { Parameter, Value, Values } from "../../../wire/protocol";

export class JobParameters {
  readonly #ask: () => Promise<readonly Parameter[]>;

  /** `ask` requests the table from the server. */
  constructor(ask: () => Promise<readonly Parameter[]>) {
    this.#ask = ask;
  }

  /** The table; empty before the request. */
  readonly table = signal<readonly Parameter[]>([]);
  /** The changed parameters, by name. */
  readonly values = signal<Values>({});

  /** Request the table once. */
  async load(): Promise<void> {
    if (this.table.peek().length > 0) return;
    try {
      this.table.value = await this.#ask();
    } catch {
      // The server does not answer: try again when the group is opened again.
    }
  }

  readonly set = (name: string, value: Value): void => {
    this.values.value = { ...this.values.peek(), [name]: value };
  };

  /** Use the parameters of an older job. */
  adopt(values: Values): void {
    if (Object.keys(this.values.peek()).length === 0) this.values.value = values;
  }

  readonly reset = (): void => {
    this.values.value = {};
  };

  /** Those that differ from the initial values. */
  changed(): Values {
    const first = new Map(this.table.peek().map((row) => [row.name, row.initial]));
    return Object.fromEntries(Object.entries(this.values.peek()).filter(([name, value]) => first.get(name) !== value));
  }
}
