/** The 3D map of the simulated robot: its newest message, and the values of its parameters. */

import { signal } from "@preact/signals";
import type { Map3dMessage } from "../wire/protocol";
import { Optimistic } from "./optimistic";

export class Map3d {
  /** Null before the first message. */
  readonly message = signal<Map3dMessage | null>(null);
  readonly values = new Optimistic();
  /** Whether what only the 3D map has is laid over the belief. */
  readonly isOver = signal(false);
  /** Whether the user has ended it: it does not begin by itself then. */
  readonly isEnded = signal(false);

  take(message: Map3dMessage): void {
    this.message.value = message;
    this.values.update(message.values);
  }
}
