import { useSignal } from "@preact/signals";
import { Button } from "../../../ui/Button";
import type { NotesState } from "./useNotes";

/** The text of the chosen note over the map, until it is closed: for a guest, who came for it. */
export function NoteCard({ state }: { readonly state: NotesState }) {
  const closed = useSignal<string | null>(null);
  const note = (state.notes.value ?? []).find(({ id }) => id === state.chosen.value);
  if (!note || closed.value === note.id) return null;
  return (
    <aside class="note-card" aria-label="Note">
      <p class="note-text">{note.text}</p>
      <Button
        kind="quiet"
        icon="close"
        label="Close the note"
        onClick={() => {
          closed.value = note.id;
        }}
      />
    </aside>
  );
}
