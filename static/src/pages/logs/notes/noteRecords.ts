/** The notes on a log: kept by the server, pinned to a time, a place or both. */

import type { Trajectory } from "../../../wire/protocol";

export interface Pin {
  /** Seconds after the log's first scan, and the number of scans in the map then. */
  readonly at_s: number | null;
  readonly scan: number | null;
  /** A place on the map, metres. */
  readonly x: number | null;
  readonly y: number | null;
}

export interface Note extends Pin {
  readonly id: string;
  readonly text: string;
  readonly created_s: number;
  readonly changed_s: number;
  /** Whether this visitor wrote it, and may change it. */
  readonly mine: boolean;
}

async function asked<T>(address: string, method = "GET", body?: unknown): Promise<T> {
  const answer = await fetch(address, {
    method,
    ...(body === undefined ? {} : { body: JSON.stringify(body), headers: { "Content-Type": "application/json" } }),
  });
  const found: unknown = answer.status === 204 ? null : await answer.json();
  if (!answer.ok) throw new Error((found as { message?: string }).message ?? "The note could not be saved.");
  return found as T;
}

const notesAddress = (session: string, id = ""): string =>
  `/api/sessions/${encodeURIComponent(session)}/notes${id && `/${encodeURIComponent(id)}`}`;

export async function fetchNotes(session: string): Promise<readonly Note[]> {
  return (await asked<{ notes: readonly Note[] }>(notesAddress(session))).notes;
}

/** Keep a note; `id` of one that is changed. */
export function keepNote(session: string, text: string, pin: Pin, id?: string): Promise<Note> {
  return asked(notesAddress(session, id), id === undefined ? "POST" : "PUT", { text, ...pin });
}

export function deleteNote(session: string, id: string): Promise<void> {
  return asked(notesAddress(session, id), "DELETE");
}

/**
 * The number of scans in the map at a note's time, null for a note without one. Another sensor of the log has other
 * scans at the same time, so that the seconds count where the log has times.
 */
export function scanOf(note: Pin, trajectory: Trajectory | null, count: number): number | null {
  if (note.scan === null || note.at_s === null) return null;
  const stamps = trajectory?.stamps ?? [];
  if (!trajectory || (stamps.at(-1) ?? 0) <= 0) return Math.min(note.scan, count);
  let low = 0;
  let high = stamps.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((stamps[middle] ?? 0) < note.at_s) low = middle + 1;
    else high = middle;
  }
  const coarse = low * trajectory.every + 1;
  // The trajectory has every so manieth scan: where the note's own number is as near, it is exact.
  return Math.min(Math.abs(note.scan - coarse) <= trajectory.every ? note.scan : coarse, count);
}
