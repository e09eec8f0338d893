/** The service's puzzles: which there are, an attempt at one, and what this browser remembers of earlier ones. */

import { signal } from "@preact/signals";
import { ask } from "../../wire/ask";
import type { Attempt, PuzzleList, SessionAnswer } from "../../wire/http";
import { followMaking, type Making, newName } from "../making";

/** The puzzles of the list, with those that the visitor made; null until they were first fetched. */
export const listed = signal<PuzzleList | null>(null);

export async function fetchList(): Promise<void> {
  listed.value = await ask("GET /api/puzzles", {});
}

export const removePuzzle = (token: string): Promise<void> => ask("DELETE /api/puzzles/{token}", { token });

export const giveToClass = (code: string, puzzle: string): Promise<void> =>
  ask("PUT /api/classes/{code}/puzzle", { code }, { body: { puzzle } });

/** The progress of a puzzle that the server prepares. */
export const preparing = signal<Making | null>(null);

/** What an attempt begins with: a puzzle of the program, one that was made, or that of a class. */
export type Beginning = { readonly puzzle: string } | { readonly token: string } | { readonly code: string };

function begun(at: Beginning, options: { query: { name: string }; ending: AbortSignal }): Promise<SessionAnswer> {
  if ("code" in at) return ask("POST /api/classes/{code}/puzzle/sessions", at, options);
  if ("token" in at) return ask("POST /api/shared-puzzles/{token}/sessions", at, options);
  return ask("POST /api/puzzles/{puzzle}/sessions", at, options);
}

/** Begin an attempt. Resolves to the id of its session. */
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

/** Go on with the attempt of a session. */
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

/** The best points in puzzles that were solved in this browser, by name. */
export const solvedPoints = (): Readonly<Record<string, number>> => stored();

export function rememberSolved(name: string, points: number): void {
  const all = stored();
  try {
    localStorage.setItem(KEY, JSON.stringify({ ...all, [name]: Math.max(points, all[name] ?? 0) }));
  } catch {
    // The browser forbids it: nothing is remembered.
  }
}
