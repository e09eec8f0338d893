/** The notes on a log, stored by the server, pinned to a time, a place or both. */

import { ask } from "../../../wire/ask";
import type { NoteAnswer } from "../../../wire/http";
import type { Point, Trajectory } from "../../../wire/protocol";

export interface Pin {
  /** Seconds after the log's first scan, and the number of scans in the map at that time. */
  readonly at_s: number | null;
  readonly scan: number | null;
  /** A place on the map, metres. */
  readonly x: number | null;
  readonly y: number | null;
  /** The corners of an area on the map, metres; its place is the centroid, computed by the server. */
  readonly outline: readonly Point[] | null;
}

export async function fetchNotes(session: string): Promise<readonly NoteAnswer[]> {
  return (await ask("GET /api/sessions/{session_id}/notes", { session_id: session })).notes;
}

/** Save a note; `id` for an existing one. */
export function keepNote(session: string, text: string, pin: Pin, id?: string): Promise<NoteAnswer> {
  const body = { text, ...pin };
  if (id === undefined) return ask("POST /api/sessions/{session_id}/notes", { session_id: session }, { body });
  return ask("PUT /api/sessions/{session_id}/notes/{note_id}", { session_id: session, note_id: id }, { body });
}

export function deleteNote(session: string, id: string): Promise<void> {
  return ask("DELETE /api/sessions/{session_id}/notes/{note_id}", { session_id: session, note_id: id });
}

/**
 * The number of scans in the map at a note's time, null for a note without a time. Another sensor of the log has other
 * scans at the same time, so the seconds count if the log has times.
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
  // The trajectory may have only some of the scans. If the note's own number is equally near, it is exact.
  return Math.min(Math.abs(note.scan - coarse) <= trajectory.every ? note.scan : coarse, count);
}
