/** A store and the stream that feeds it. */

import type { ReadonlySignal } from "@preact/signals";
import { Store } from "./state";
import { type Status, Stream } from "./stream";

export interface Connection {
  readonly store: Store;
  readonly status: ReadonlySignal<Status>;
  readonly stream: Stream;
  start(): void;
  stop(): void;
}

/** Watch a session. Nothing happens before `start`. */
export function connect(session: string): Connection {
  const id = encodeURIComponent(session);
  const url = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/sessions/${id}/stream`;
  const isGone = async (): Promise<boolean> => {
    try {
      return (await fetch(`/api/sessions/${id}`)).status === 404;
    } catch {
      return false; // the server is away, which says nothing of the session
    }
  };
  let stream: Stream;
  const store = new Store((command) => stream.send(command));
  stream = new Stream(url, store, isGone);
  return { store, stream, status: stream.status, start: () => stream.start(), stop: () => stream.stop() };
}
