import { stillness } from "../figures/picture/pulse";

const KEY = "gridbloom.world";

/**
 * Ask the server for a new live world, or for one in which a story has happened; the id of its session. Who wants less
 * motion gets one that stands still, and lets it go on by steps.
 */
export async function createWorld(story?: { readonly world: string; readonly seed: number }): Promise<string> {
  const begin = { kind: "world", playing: !stillness.peek() };
  const wanted = story ? { ...begin, world: story.world, seed: story.seed, story } : begin;
  const answer = await fetch("/api/sessions", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(wanted),
  });
  const body = (await answer.json()) as { id?: string; message?: string };
  if (!answer.ok || !body.id) throw new Error(body.message ?? `The server answered ${answer.status}.`);
  return body.id;
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
