/** A second map of the same session, beside the first: its picture, and nothing else. */

import type { TilesFrame } from "../wire/decodeTiles";
import type { ServerMessage } from "../wire/protocol";
import { streamOf } from "./connect";
import { DisplayedMap } from "./displayedMap";
import type { Progress, Receiver, Stream } from "./stream";

export class SecondMap implements Receiver {
  readonly shown = new DisplayedMap();
  readonly #stream: Stream;
  #epochId: string | undefined;

  constructor(streamInto: (receiver: Receiver) => Stream) {
    this.#stream = streamInto(this);
  }

  start(): void {
    this.#stream.start();
  }

  stop(): void {
    this.#stream.stop();
  }

  receive(message: ServerMessage): void {
    if (message.type === "geometry") this.shown.begin(message);
    if (message.type !== "hello") return;
    if (this.#epochId !== undefined && this.#epochId !== message.epoch_id) this.forget();
    this.#epochId = message.epoch_id;
  }

  takeTiles(frame: TilesFrame): void {
    this.shown.takeTiles(frame);
  }

  progress(): Progress | null {
    return this.shown.progress(this.#epochId);
  }

  forget(): void {
    this.shown.forget();
  }
}

/** Watch the second map of a session, while there is one. */
export function connectSecond(session: string): SecondMap {
  return new SecondMap((receiver) => streamOf(session, receiver, "?map=second"));
}
