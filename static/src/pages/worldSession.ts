import { signal } from "@preact/signals";
import { FIRST_SEED } from "../store/firstPicture";
import { reducedMotion } from "../ui/browser/media";
import type { Work } from "../ui/Working";
import { ask, mayPass, RequestError } from "../wire/ask";
import type { History, NewSimulation } from "../wire/http";
import { followMaking, newName } from "./making";

const KEY = "gridbloom.world";

/** The history of a live world, which only the server interprets. */
export type Story = History & { readonly world: string; readonly seed: number };

/** The progress of a world that the server replays from its history, and a function that cancels it. */
interface Replay {
  readonly work: Work;
  cancel(): void;
}

/** The replay in progress; null while there is none. */
export const replay = signal<Replay | null>(null);

/** Duration of a pending request for a world; null at first, and without one. */
export const starting = signal<Work | null>(null);

/** A request that takes longer shows its progress. */
const SHOWN_AFTER_MS = 300;

/** The visitor cancelled the replay. */
export class CancelledError extends Error {}

/** The server will not make this world, even if it is requested again. */
export class RefusedError extends Error {}

/**
 * Request a new live world from the server, or one replayed from a history. Returns the id of its session. With reduced
 * motion, or if `isPaused`, the world is paused. Throws {@link CancelledError} if the visitor cancels the replay, and
 * {@link RefusedError} if the server will never make the world.
 */
export async function createWorld(story?: Story, isPaused = false): Promise<string> {
  const begin = { kind: "simulation", playing: !(isPaused || reducedMotion.peek()) } as const;
  if (!story) return await timed(() => post({ ...begin, seed: FIRST_SEED }));
  const name = newName();
  const ending = new AbortController();
  const stop = followMaking(name, (work) => {
    replay.value = work && { work, cancel: () => ending.abort() };
  });
  try {
    return await post({ ...begin, world: story.world, seed: story.seed, story, name }, ending.signal);
  } catch (error) {
    if (ending.signal.aborted) throw new CancelledError("The replay was cancelled.");
    throw error;
  } finally {
    stop();
  }
}

/** Wait for a request, and show its duration in {@link starting}. */
async function timed<T>(request: () => Promise<T>): Promise<T> {
  const began = performance.now();
  const clock = setInterval(() => {
    starting.value = { elapsed_s: (performance.now() - began) / 1000, fraction: null };
  }, SHOWN_AFTER_MS);
  try {
    return await request();
  } finally {
    clearInterval(clock);
    starting.value = null;
  }
}

async function post(body: NewSimulation, ending?: AbortSignal): Promise<string> {
  try {
    return (await ask("POST /api/sessions", {}, { body, ending })).id;
  } catch (error) {
    throw error instanceof RequestError && !mayPass(error) ? new RefusedError(error.message) : error;
  }
}

/** The session storage; null if the browser forbids it. */
function storage(): Storage | null {
  try {
    return sessionStorage;
  } catch {
    return null;
  }
}

/** Whether this tab has had a live world, which it continues if the server still has it. */
export const hadWorld = (): boolean => Boolean(storage()?.getItem(KEY));

/** The session id of this tab's live world: the previous one if the server still has it, otherwise a new one. */
export async function worldSession(): Promise<string> {
  const before = storage()?.getItem(KEY);
  if (before) {
    try {
      return (await timed(() => ask("GET /api/sessions/{session_id}", { session_id: before }))).id;
    } catch (error) {
      if (mayPass(error)) throw error;
    }
  }
  const id = await createWorld();
  storage()?.setItem(KEY, id);
  return id;
}
