/** The list of logs, and requests about one of them. */

import { effect, signal } from "@preact/signals";
import { reducedMotion } from "../../../ui/browser/media";
import { ask as send, whyAgain } from "../../../wire/ask";
import type { LogAnswer, NewVolume, SessionAnswer, Topic } from "../../../wire/http";
import { followMaking, type Making, newName } from "../../making";

export type { LogAnswer as LogRecord, Topic };

/** Which logs are listed: their words and tags, their order, and the maximum number. */
export interface Wanted {
  readonly words: string;
  readonly tags: readonly string[];
  readonly order: (typeof ORDERS)[number]["value"];
  readonly limit: number;
}

export const ORDERS = [
  { value: "newest", label: "newest first" },
  { value: "name", label: "by name" },
  { value: "duration", label: "longest first" },
  { value: "scans", label: "most scans first" },
  { value: "size", label: "largest first" },
] as const;

/** Number of logs on one page of the list. */
export const PAGE = 24;
export const EVERYTHING: Wanted = { words: "", tags: [], order: "newest", limit: PAGE };

export const wanted = signal<Wanted>(EVERYTHING);
/** The matching logs; null until they were first fetched. */
export const logs = signal<readonly LogAnswer[] | null>(null);
/** Their total number, beyond the page as well. */
export const total = signal(0);
/** The visitor's tags, each with the number of its logs. */
export const allTags = signal<Readonly<Record<string, number>>>({});
/** A single file that was uploaded here and is opened once it has been read. */
export const arrived = signal<string | null>(null);

/** Why the list could not be fetched. */
export const listError = signal<string | null>(null);

let timer: ReturnType<typeof setTimeout> | undefined;

export const isMoving = (log: LogAnswer): boolean => log.state === "queued" || log.state === "reading";

const isUnknown = (log: LogAnswer): boolean => isMoving(log) || (log.state === "ready" && log.scans === null);

let isWatched = false;
let isWhole = false;

/** Keep the list of all logs up to date until the returned function is called. */
export function watchAll(): () => void {
  isWhole = true;
  return watch();
}

/** Keep the list of these logs up to date until the returned function is called. */
export function watch(): () => void {
  isWatched = true;
  const stop = effect(() => {
    void wanted.value;
    void refresh();
  });
  return () => {
    isWatched = isWhole = false;
    clearTimeout(timer);
    stop();
  };
}

/** The query of the list. */
const queryOf = ({ words, tags, order, limit }: Wanted) => ({ order, limit, ...(words && { q: words }), tag: tags });

let asked = 0;

/** Fetch the list, repeatedly while it is shown and a log is being read or the server does not answer. */
export async function refresh(): Promise<void> {
  clearTimeout(timer);
  asked += 1;
  const own = asked;
  let again = 0;
  try {
    const body = await send("GET /api/logs", {}, isWhole ? {} : { query: queryOf(wanted.peek()) });
    if (own !== asked) return; // another list was requested meanwhile
    logs.value = body.logs;
    total.value = body.total;
    allTags.value = body.tags;
    listError.value = null;
    if (body.logs.some(isUnknown)) again = 500;
  } catch (error) {
    listError.value = whyAgain(error);
    again = 3000;
  }
  if (again > 0 && isWatched) timer = setTimeout(() => void refresh(), document.hidden ? 5 * again : again);
}

/** The error message of a request that is refused, or null. */
const refusalOf = (request: Promise<unknown>): Promise<string | null> =>
  request.then(
    () => null,
    (error: Error) => error.message,
  );

/** Delete one's own log; resolves to an error message, or null. */
export const remove = (id: string): Promise<string | null> =>
  refusalOf(
    send("DELETE /api/logs/{log_id}", { log_id: id }).then(() => {
      logs.value = (logs.value ?? []).filter((log) => log.id !== id);
    }),
  );

/** Give a log other tags; resolves to an error message, or null. */
export const putTags = (id: string, tags: readonly string[]): Promise<string | null> =>
  refusalOf(
    send("PUT /api/logs/{log_id}/tags", { log_id: id }, { body: { tags } }).then(() => {
      void refresh();
    }),
  );

/** Request that the server stops reading one's own log, or reads it again; resolves to an error message, or null. */
export const ask = (id: string, what: "cancel" | "read"): Promise<string | null> =>
  refusalOf(
    send(`POST /api/logs/{log_id}/${what}`, { log_id: id }).then((fresh) => {
      logs.value = (logs.value ?? []).map((log) => (log.id === id ? fresh : log));
      void refresh();
    }),
  );

/** The progress of the log that is being opened; null while there is none. */
/** The examples of the server. */
export type ExampleName = "drift" | "mount" | "camera";

/** Request an example log, which is opened once it has been read. */
export async function openExample(name: ExampleName): Promise<void> {
  const log = await send("POST /api/logs/examples/{name}", { name });
  arrived.value = log.id;
  await refresh();
}

export const opening = signal<Making | null>(null);

/**
 * Open a session on a log; rejects with an error message. `ending` aborts the request. With reduced motion the map of
 * all scans is shown immediately; not for a session that follows a running job, because a seek would end that.
 */
export async function openSession(
  log: string,
  topic: string | null,
  ending: AbortSignal,
  volume: Pick<NewVolume, "other" | "up"> | null = null,
): Promise<SessionAnswer> {
  const name = newName();
  const stop = followMaking(name, (making) => {
    opening.value = making;
  });
  try {
    const isStill = reducedMotion.peek();
    const common = { log, topic, name, playing: !isStill };
    const body = volume
      ? ({ kind: "volume", ...common, ...volume } as const)
      : ({ kind: "log", ...common, whole: isStill } as const);
    return await send("POST /api/sessions", {}, { body, ending });
  } finally {
    stop();
  }
}
