/** What is shown of a map in 3D, and how, as the user wants it. */

import type { Optimistic } from "../../store/optimistic";
import type { Store } from "../../store/store";

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
