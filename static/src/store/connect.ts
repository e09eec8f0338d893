/** A store and the stream that it receives from. */

import type { ReadonlySignal } from "@preact/signals";
import { Store } from "./store";
import { type Status, Stream } from "./stream";

export interface Connection {
  readonly store: Store;
  readonly status: ReadonlySignal<Status>;
  /** An error of the connection in one or two sentences; null for none. */
  readonly trouble: ReadonlySignal<string | null>;
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
    return false; // the server does not answer: nothing is known about the session
  }
}

/** Prepare a connection to a session; `start` opens it. */
export function connect(session: string): Connection {
  let stream: Stream;
  const store = new Store((command) => stream.send(command));
  stream = new Stream(address(session), store, () => isGone(session));
  const { status, trouble } = stream;
  return { store, stream, status, trouble, start: () => stream.start(), stop: () => stream.stop() };
}
