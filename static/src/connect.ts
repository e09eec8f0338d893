/** A store and the stream that feeds it. */

import type { ReadonlySignal } from "@preact/signals";
import { SecondMap } from "./secondMap";
import { Store } from "./state";
import { type Status, Stream } from "./stream";

export interface Connection {
  readonly store: Store;
  readonly status: ReadonlySignal<Status>;
  readonly stream: Stream;
  start(): void;
  stop(): void;
}

const address = (session: string): string =>
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/sessions/${encodeURIComponent(session)}/stream`;

async function isGone(session: string): Promise<boolean> {
  try {
    return (await fetch(`/api/sessions/${encodeURIComponent(session)}`)).status === 404;
  } catch {
    return false; // the server is away, which says nothing of the session
  }
}

/** Watch the second map of a session, while there is one. */
export function connectSecond(session: string): SecondMap {
  return new SecondMap((receiver) => new Stream(`${address(session)}?map=second`, receiver, () => isGone(session)));
}

/** Watch a session. Nothing happens before `start`. */
export function connect(session: string): Connection {
  let stream: Stream;
  const store = new Store((command) => stream.send(command));
  stream = new Stream(address(session), store, () => isGone(session));
  return { store, stream, status: stream.status, start: () => stream.start(), stop: () => stream.stop() };
}
