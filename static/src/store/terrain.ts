/** The terrain of the simulated robot's 3D map: its newest message, and the values of its parameters. */

import { signal } from "@preact/signals";
import type { TerrainMessage } from "../wire/protocol";
import { Optimistic } from "./optimistic";

export class Terrain {
  /** Null before the first message. */
  readonly message = signal<TerrainMessage | null>(null);
  readonly values = new Optimistic();
  /** Whether the user has ended it: it does not begin by itself then. */
  readonly isEnded = signal(false);

  take(message: TerrainMessage): void {
    this.message.value = message;
    this.values.update(message.values);
  }
}
