/** The display options of a 3D map: their table with the values, and functions to change them. */

import { type ReadonlySignal, useComputed } from "@preact/signals";
import type { Optimistic } from "../../store/optimistic";
import type { Store } from "../../store/store";
import type { Parameter, Value, Values } from "../../wire/protocol";

/** The user's display options of a 3D map. */
class LookState {
  readonly values: Optimistic;

  constructor(store: Store) {
    const { message, values } = store.part("volume");
    this.values = values;
    store.joins("volume_look");
    message.subscribe((volume) => volume && values.update(volume.look.values));
  }
}

export const lookOf = (store: Store): Optimistic => store.of(LookState).values;

export interface Look {
  readonly rows: readonly Parameter[];
  readonly values: ReadonlySignal<Values>;
  readonly set: (name: string, value: Value) => void;
  /** Set several values at once. */
  readonly setAll: (values: Values) => void;
}

/** Null until the session has sent them. */
export function useLook(store: Store): Look | null {
  const values = useComputed(() => lookOf(store).values.value);
  const table = store.part("volume").message.value?.look.table;
  if (!table) return null;
  const setAll = (wanted: Values): void => {
    for (const [name, value] of Object.entries(wanted)) lookOf(store).set(name, value);
    store.sendSoon({ type: "volume_look", values: wanted });
  };
  return { rows: table, values, set: (name, value) => setAll({ [name]: value }), setAll };
}
