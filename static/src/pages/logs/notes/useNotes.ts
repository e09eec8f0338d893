import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import type { NoteAnswer } from "../../../wire/http";
import { deleteNote, fetchNotes, keepNote, type Pin } from "./noteRecords";

export interface NotesState {
  /** Null until they are known. */
  readonly notes: Signal<readonly NoteAnswer[] | null>;
  /** The id of the note that is selected on the slider, on the map or in the list. */
  readonly chosen: Signal<string | null>;
  readonly failure: Signal<string | null>;
  readonly refresh: () => Promise<void>;
  /** Resolve to whether it succeeded. */
  readonly keep: (text: string, pin: Pin, id?: string) => Promise<boolean>;
  readonly remove: (id: string) => Promise<boolean>;
}

/**
 * The notes on the log of a session, fetched again after each change. `first` is the id of the initially selected one.
 */
export function useNotes(session: string, store: Store, first: string | null = null): NotesState {
  const notes = useSignal<readonly NoteAnswer[] | null>(null);
  const chosen = useSignal<string | null>(first);
  const failure = useSignal<string | null>(null);
  const attempt = async (work: () => Promise<unknown>): Promise<boolean> => {
    try {
      await work();
      failure.value = null;
      return true;
    } catch (error) {
      failure.value = (error as Error).message;
      return false;
    }
  };
  const fetchAll = async (): Promise<void> => {
    notes.value = await fetchNotes(session);
  };
  const refresh = async (): Promise<void> => void (await attempt(fetchAll));
  useEffect(() => void refresh(), [session]);
  useSignalEffect(() => {
    if (store.part("notes").message.value !== null) void refresh();
  });
  return {
    notes,
    chosen,
    failure,
    refresh,
    keep: (text, pin, id) =>
      attempt(async () => {
        chosen.value = (await keepNote(session, text, pin, id)).id;
        await fetchAll();
      }),
    remove: (id) =>
      attempt(async () => {
        await deleteNote(session, id);
        await fetchAll();
      }),
  };
}
