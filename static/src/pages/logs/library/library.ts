/** The list of logs, and what is asked of the server about one of them. */

import { effect, signal } from "@preact/signals";
import { reducedMotion } from "../../../ui/browser/reducedMotion";
import type { LogAnswer, LogList, Topic } from "../../../wire/http";
import { followMaking, type Making, newName } from "../../making";

export type { LogAnswer as LogRecord, Topic };

/** Which logs are listed: words and tags that they have, their order, and how many. */
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

/** Logs of one page of the list. */
export const PAGE = 24;
export const EVERYTHING: Wanted = { words: "", tags: [], order: "newest", limit: PAGE };

export const wanted = signal<Wanted>(EVERYTHING);
/** The logs that were found; null until they were first fetched. */
export const logs = signal<readonly LogAnswer[] | null>(null);
/** How many there are of them, also beyond the page. */
export const total = signal(0);
/** The visitor's tags, each with the number of its logs. */
export const allTags = signal<Readonly<Record<string, number>>>({});
/** The log of a single file that was uploaded here, to be opened once it was read. */
export const arrived = signal<string | null>(null);

/** The logs page, which opens what has arrived on another page. */
export const arrivalAddress = (id: string | null): string =>
  id === null ? "/logs.html" : `/logs.html?arrived=${encodeURIComponent(id)}`;
/** Why the list could not be fetched. */
export const listError = signal<string | null>(null);

export const AWAY = "The server does not answer. The page tries again by itself.";

/** The error message in an answer of the server, or a general one. */
export async function sentence(answer: Response): Promise<string> {
  try {
    const body: unknown = await answer.json();
    if (body && typeof body === "object" && "message" in body && typeof body.message === "string") return body.message;
  } catch {
    // not JSON: for example the error page of a proxy
  }
  return `The server answered ${answer.status}.`;
}

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

/** Keep the list of the wanted logs up to date until the returned function is called. */
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

/** The address of the list. */
function address({ words, tags, order, limit }: Wanted): string {
  const query = new URLSearchParams({ order, limit: String(limit) });
  if (words) query.set("q", words);
  for (const tag of tags) query.append("tag", tag);
  return `/api/logs?${query}`;
}

let asked = 0;

/** Fetch the list; repeated while it is watched and a log is still being read or the server does not answer. */
export async function refresh(): Promise<void> {
  clearTimeout(timer);
  asked += 1;
  const own = asked;
  let again = 0;
  try {
    const answer = await fetch(isWhole ? "/api/logs" : address(wanted.peek()));
    if (!answer.ok) throw new Error(await sentence(answer));
    const body = (await answer.json()) as LogList;
    if (own !== asked) return; // another list was asked for meanwhile
    logs.value = body.logs;
    total.value = body.total;
    allTags.value = body.tags;
    listError.value = null;
    if (body.logs.some(isUnknown)) again = 500;
  } catch (error) {
    listError.value = error instanceof TypeError ? AWAY : (error as Error).message;
    again = 3000;
  }
  if (again > 0 && isWatched) timer = setTimeout(() => void refresh(), document.hidden ? 5 * again : again);
}

/** Delete one's own log; resolves to an error message, or null. */
export async function remove(id: string): Promise<string | null> {
  try {
    const answer = await fetch(`/api/logs/${encodeURIComponent(id)}`, { method: "DELETE" });
    if (!answer.ok) return await sentence(answer);
    logs.value = (logs.value ?? []).filter((log) => log.id !== id);
    return null;
  } catch {
    return AWAY;
  }
}

/** Give a log other tags; resolves to an error message, or null. */
export async function putTags(id: string, tags: readonly string[]): Promise<string | null> {
  try {
    const answer = await fetch(`/api/logs/${encodeURIComponent(id)}/tags`, {
      method: "PUT",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ tags }),
    });
    if (!answer.ok) return await sentence(answer);
    void refresh();
    return null;
  } catch {
    return AWAY;
  }
}

/** Request that the server stops reading one's own log, or reads it again; resolves to an error message, or null. */
export async function ask(id: string, what: "cancel" | "read"): Promise<string | null> {
  try {
    const answer = await fetch(`/api/logs/${encodeURIComponent(id)}/${what}`, { method: "POST" });
    if (!answer.ok) return await sentence(answer);
    const fresh = (await answer.json()) as LogAnswer;
    logs.value = (logs.value ?? []).map((log) => (log.id === id ? fresh : log));
    void refresh();
    return null;
  } catch {
    return AWAY;
  }
}

/** The progress of the log that is being opened; null while there is none. */
export const opening = signal<Making | null>(null);

/** A session: its id and its kind. */
export interface OpenedSession {
  readonly id: string;
  readonly kind: string;
}

/**
 * Open a session on a log; rejects with an error message. `ending` ends the request. With reduced motion the map of all
 * scans is shown at once: a seek would end that the session follows a job which is under way.
 */
export async function openSession(
  log: string,
  topic: string | null,
  ending: AbortSignal,
  volume: { readonly other: string | null; readonly up: string | null } | null = null,
): Promise<OpenedSession> {
  const name = newName();
  const stop = followMaking(name, (making) => {
    opening.value = making;
  });
  try {
    const answer = await fetch("/api/sessions", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({
        kind: volume ? "volume" : "log",
        log,
        topic,
        name,
        playing: !reducedMotion.peek(),
        ...(volume ? {} : { whole: reducedMotion.peek() }),
        ...(volume?.other ? { other: volume.other } : {}),
        ...(volume?.up ? { up: volume.up } : {}),
      }),
      signal: ending,
    });
    if (!answer.ok) throw new Error(await sentence(answer));
    return (await answer.json()) as OpenedSession;
  } finally {
    stop();
  }
}
