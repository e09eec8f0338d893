/** The service's puzzles: the list, an attempt at one, and this browser's record of earlier ones. */

import { signal } from "@preact/signals";
import { ask } from "../../wire/ask";
import type { Attempt, PuzzleList, SessionAnswer } from "../../wire/http";
import { followMaking, type Making, newName } from "../making";

/** The puzzles of the list and those made by the visitor; null until they were first fetched. */
export const listed = signal<PuzzleList | null>(null);

export async function fetchList(): Promise<void> {
  listed.value = await ask("GET /api/puzzles", {});
}

export const removePuzzle = (token: string): Promise<void> => ask("DELETE /api/puzzles/{token}", { token });

export const giveToClass = (code: string, puzzle: string): Promise<void> =>
  ask("PUT /api/classes/{code}/puzzle", { code }, { body: { puzzle } });

/** Progress of the puzzle that the server is preparing. */
export const preparing = signal<Making | null>(null);

/** The puzzle of an attempt: one of the program, one made by a visitor, or that of a class. */
export type Beginning = { readonly puzzle: string } | { readonly token: string } | { readonly code: string };

function begun(at: Beginning, options: { query: { name: string }; ending: AbortSignal }): Promise<SessionAnswer> {
  if ("code" in at) return ask("POST /api/classes/{code}/puzzle/sessions", at, options);
  if ("token" in at) return ask("POST /api/shared-puzzles/{token}/sessions", at, options);
  return ask("POST /api/puzzles/{puzzle}/sessions", at, options);
}

/** Start an attempt. Resolves to the id of its session. */
export async function beginAttempt(at: Beginning, ending: AbortSignal): Promise<string> {
  const name = newName();
  const stop = followMaking(name, (making) => {
    preparing.value = making;
  });
  try {
    return (await begun(at, { query: { name }, ending })).id;
  } finally {
    stop();
  }
}

/** The attempt of a session. */
export const attemptOf = (session: string): Promise<Attempt> =>
  ask("GET /api/sessions/{session_id}/puzzle", { session_id: session });

/** Continue the attempt of a session. */
export const step = (session: string, what: "hint" | "solution" | "check"): Promise<Attempt> =>
  ask(`POST /api/sessions/{session_id}/puzzle/${what}`, { session_id: session });

export const nameCause = (session: string, cause: string): Promise<Attempt> =>
  ask("POST /api/sessions/{session_id}/puzzle/answer", { session_id: session }, { body: { cause } });

const KEY = "gridbloom.puzzles";

function stored(): Record<string, number> {
  try {
    return JSON.parse(localStorage.getItem(KEY) ?? "{}") as Record<string, number>;
  } catch {
    return {};
  }
}

/** The best points in puzzles solved in this browser, by name. */
export const solvedPoints = (): Readonly<Record<string, number>> => stored();

export function rememberSolved(name: string, points: number): void {
  const all = stored();
  try {
    localStorage.setItem(KEY, JSON.stringify({ ...all, [name]: Math.max(points, all[name] ?? 0) }));
  } catch {
    // The browser forbids storage: nothing is recorded.
  }
}
