/** A store and the stream that it receives from. */

import type { ReadonlySignal } from "@preact/signals";
import { addressOf, socketAddress } from "../wire/ask";
import { type Command, ENDED } from "../wire/protocol";
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

async function isGone(path: string): Promise<boolean> {
  try {
    return (await fetch(path)).status === 404;
  } catch {
    return false; // the server does not answer, so nothing is known about the session
  }
}

/** Prepare a connection to a session; `start` opens it. */
export function connect(session: string): Connection {
  const path = addressOf("GET /api/sessions/{session_id}", { session_id: session });
  return connection(
    (page) => `${path}/stream?page=${page}`,
    async (code) => code === ENDED || (await isGone(path)),
    () => true,
  );
}

/** Commands that a follower of a class may send, because they change nothing. */
const HARMLESS: readonly Command["type"][] = ["ack", "resume", "subscribe", "ping", "inspect"];
const DRIVING: readonly Command["type"][] = ["drive", "teleport", "auto"];

/** Prepare a connection to the session that the lecturer of a class shows. Only with `drives` can it be controlled. */
export function connectToClass(code: string, drives: () => boolean): Connection {
  const path = addressOf("GET /api/classes/{code}", { code });
  return connection(
    () => `${path}/session`,
    () => isGone(path), // a session that has ended is no longer shown by the class
    ({ type }) => HARMLESS.includes(type) || (DRIVING.includes(type) && drives()),
  );
}

function connection(
  streamPath: (page: string) => string,
  isOver: (code?: number) => Promise<boolean>,
  may: (command: Command) => boolean,
): Connection {
  let stream: Stream;
  const store = new Store((command) => may(command) && stream.send(command));
  stream = new Stream(socketAddress(streamPath(store.page)), store, isOver);
  const { status, trouble } = stream;
  return { store, stream, status, trouble, start: () => stream.start(), stop: () => stream.stop() };
}
