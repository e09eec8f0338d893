import { signal } from "@preact/signals";
import { reducedMotion } from "../ui/reducedMotion";
import type { Work } from "../ui/Working";

const KEY = "gridbloom.world";
/** A replay that takes longer shows how far it is. */
const SHOWN_AFTER_MS = 300;
const ASK_EVERY_MS = 250;

/** A world that the server replays from its story, and how to end that. */
export interface Replay {
  readonly work: Work;
  cancel(): void;
}

/** The replay that this page waits for; null while there is none. */
export const replay = signal<Replay | null>(null);

/** The person ended the replay. */
export class CancelledError extends Error {}

/**
 * Ask the server for a new live world, or for one in which a story has happened; the id of its session. Who wants less
 * motion gets one that stands still, and lets it go on by steps. Throws {@link CancelledError} where a person did not
 * want to wait for the story.
 */
export async function createWorld(story?: { readonly world: string; readonly seed: number }): Promise<string> {
  const begin = { kind: "simulation", playing: !reducedMotion.peek() };
  if (!story) return await asked(begin);
  const name = Array.from(crypto.getRandomValues(new Uint32Array(3)), (n) => n.toString(36)).join("");
  const ending = new AbortController();
  const stop = followed(name, () => ending.abort());
  try {
    return await asked({ ...begin, world: story.world, seed: story.seed, story, name }, ending.signal);
  } catch (error) {
    if (ending.signal.aborted) throw new CancelledError("The replay was cancelled.");
    throw error;
  } finally {
    stop();
  }
}

async function asked(wanted: object, ending?: AbortSignal): Promise<string> {
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

/** Show how far a replay is until the result is called. */
function followed(name: string, cancel: () => void): () => void {
  let isOver = false;
  const look = async (): Promise<void> => {
    try {
      const answer = await fetch(`/api/sessions/making/${name}`);
      if (answer.ok && !isOver) replay.value = { work: (await answer.json()) as Work, cancel };
    } catch {
      // The request for the world itself says that the server is away.
    }
    if (isOver) replay.value = null;
    else timer = setTimeout(() => void look(), ASK_EVERY_MS);
  };
  let timer = setTimeout(() => void look(), SHOWN_AFTER_MS);
  return () => {
    isOver = true;
    clearTimeout(timer);
    replay.value = null;
  };
}

/** The tab's memory; null where the person forbids it. */
function storage(): Storage | null {
  try {
    return sessionStorage;
  } catch {
    return null;
  }
}

/** The id of this tab's live world: the one it had before, where the server still has it, or a new one. */
export async function worldSession(): Promise<string> {
  const before = storage()?.getItem(KEY);
  if (before && (await fetch(`/api/sessions/${encodeURIComponent(before)}`)).ok) return before;
  const id = await createWorld();
  storage()?.setItem(KEY, id);
  return id;
}
