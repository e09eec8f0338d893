/** The surface of a map in 3D: its newest message, the values of its parameters, and the voxel that is asked about. */

import { signal } from "@preact/signals";
import type { SurfaceMessage, SurfaceVoxelMessage } from "../wire/protocol";
import { Optimistic } from "./optimistic";

export class Surface {
  /** Null before the first message. */
  readonly message = signal<SurfaceMessage | null>(null);
  readonly values = new Optimistic();
  readonly voxel = signal<SurfaceVoxelMessage | null>(null);

  take(message: SurfaceMessage): void {
    this.message.value = message;
    this.values.update(message.values);
  }
}
