import { signal } from "@preact/signals";
import { reducedMotion } from "../ui/reducedMotion";
import type { Work } from "../ui/Working";

const KEY = "gridbloom.world";
/** A replay that takes longer shows its progress. */
const SHOWN_AFTER_MS = 300;
const POLL_MS = 250;

/** The progress of a world that the server replays from its story, and how to cancel it. */
export interface Replay {
  readonly work: Work;
  cancel(): void;
}

/** The replay in progress; null while there is none. */
export const replay = signal<Replay | null>(null);

/** The visitor cancelled the replay. */
export class CancelledError extends Error {}

/**
 * Request a new live world from the server, or one replayed from a story; returns the id of its session. With reduced
 * motion the world is paused. Throws {@link CancelledError} if the visitor cancels the replay.
 */
export async function createWorld(story?: { readonly world: string; readonly seed: number }): Promise<string> {
  const begin = { kind: "simulation", playing: !reducedMotion.peek() };
  if (!story) return await post(begin);
  const name = Array.from(crypto.getRandomValues(new Uint32Array(3)), (n) => n.toString(36)).join("");
  const ending = new AbortController();
  const stop = showProgress(name, () => ending.abort());
  try {
    return await post({ ...begin, world: story.world, seed: story.seed, story, name }, ending.signal);
  } catch (error) {
    if (ending.signal.aborted) throw new CancelledError("The replay was cancelled.");
    throw error;
  } finally {
    stop();
  }
}

async function post(wanted: object, ending?: AbortSignal): Promise<string> {
  const answer = await fetch("/api/sessions", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(wanted),
    ...(ending && { signal: ending }),
  });
  const body = (await answer.json()) as { id?: string; message?: string };
  if (!answer.ok || !body.id) throw new Error(body.message ?? `The server answered ${answer.status}.`);
  return body.id;
}

/** Show the progress of a replay until the returned function is called. */
function showProgress(name: string, cancel: () => void): () => void {
  let isOver = false;
  const poll = async (): Promise<void> => {
    try {
      const answer = await fetch(`/api/sessions/making/${name}`);
      if (answer.ok && !isOver) replay.value = { work: (await answer.json()) as Work, cancel };
    } catch {
      // The request for the world itself reports that the server does not answer.
    }
    if (isOver) replay.value = null;
    else timer = setTimeout(() => void poll(), POLL_MS);
  };
  let timer = setTimeout(() => void poll(), SHOWN_AFTER_MS);
  return () => {
    isOver = true;
    clearTimeout(timer);
    replay.value = null;
  };
}

/** The session storage; null if the browser forbids it. */
function storage(): Storage | null {
  try {
    return sessionStorage;
  } catch {
    return null;
  }
}

/** The session id of this tab's live world: the previous one if the server still has it, else a new one. */
export async function worldSession(): Promise<string> {
  const before = storage()?.getItem(KEY);
  if (before && (await fetch(`/api/sessions/${encodeURIComponent(before)}`)).ok) return before;
  const id = await createWorld();
  storage()?.setItem(KEY, id);
  return id;
}
