/** The service's puzzles: which there are, an attempt at one, and what this browser remembers of earlier ones. */

import { signal } from "@preact/signals";
import { request } from "../logs/request";
import { followMaking, type Making, newName } from "../making";
import type { Attempt, Offered } from "./attempt";

/** A puzzle that this visitor made. */
export interface Made {
  readonly token: string;
  readonly address: string;
  readonly title: string;
  /** Seconds since 1970. */
  readonly created_s: number;
}

export interface AllPuzzles {
  readonly puzzles: readonly Offered[];
  readonly mine: readonly Made[];
}

export const allPuzzles = (): Promise<AllPuzzles> => request("/api/puzzles");

export const removePuzzle = (token: string): Promise<void> => request(`/api/puzzles/${token}`, "DELETE");

export const giveToClass = (code: string, puzzle: string): Promise<void> =>
  request(`/api/classes/${code}/puzzle`, "PUT", { puzzle });

/** The progress of a puzzle that the server prepares. */
export const preparing = signal<Making | null>(null);

/** Begin an attempt; `at` is the address that begins it. Resolves to the id of its session. */
export async function beginAttempt(at: string, ending: AbortSignal): Promise<string> {
  const name = newName();
  const stop = followMaking(name, (making) => {
    preparing.value = making;
  });
  try {
    return (await request<{ id: string }>(`${at}?name=${name}`, "POST", undefined, ending)).id;
  } finally {
    stop();
  }
}

/** One of the requests about the attempt of a session. */
export function ask(session: string, what?: "hint" | "solution" | "check", ending?: AbortSignal): Promise<Attempt> {
  const at = `/api/sessions/${encodeURIComponent(session)}/puzzle`;
  return what ? request(`${at}/${what}`, "POST", undefined, ending) : request(at);
}

export const nameCause = (session: string, cause: string): Promise<Attempt> =>
  request(`/api/sessions/${encodeURIComponent(session)}/puzzle/answer`, "POST", { cause });

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
