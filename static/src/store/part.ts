/** The state of a part of the session: its newest message, and the values of its parameters. */

import { signal } from "@preact/signals";
import type { ServerMessage } from "../wire/protocol";
import { Optimistic } from "./optimistic";

export class PartState<M extends ServerMessage = ServerMessage> {
  /** Null before the first message. */
  readonly message = signal<M | null>(null);
  readonly values = new Optimistic();
  /** Whether its layer is laid over the belief. */
  readonly isOver = signal(false);
  /** Whether the user has ended it: it does not begin by itself then. */
  readonly isEnded = signal(false);

  take(message: M): void {
    this.message.value = message;
    if ("values" in message) this.values.update(message.values);
  }
}
