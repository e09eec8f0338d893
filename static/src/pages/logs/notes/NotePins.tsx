import { useSignal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { type Size, toScreen } from "../../../render/view";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import type { NoteAnswer } from "../../../wire/http";
import { goToNote } from "./Notes";
import type { NotesState } from "./useNotes";

/** The text of the selected note over the map, until it is closed: for a guest whose link contains it. */
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

interface NotePinsProps {
  readonly store: Store;
  readonly state: NotesState;
  readonly onOpen: () => void;
}

/** The notes with a place, as pins on the map. */
export function NotePins({ store, state, onOpen }: NotePinsProps) {
  const layer = useRef<HTMLDivElement>(null);
  const size = useSignal<Size>({ width: 0, height: 0 });
  useLayoutEffect(() => {
    const element = layer.current;
    if (!element) return;
    const observer = new ResizeObserver(([entry]) => {
      if (entry) size.value = entry.contentRect;
    });
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  const view = store.view.value;
  const placed = (state.notes.value ?? []).filter((note) => note.x !== null && note.y !== null);
  const isInside = ([x, y]: readonly [number, number]): boolean =>
    x >= 0 && y >= 0 && x <= size.value.width && y <= size.value.height;
  const place = (note: NoteAnswer): readonly [number, number] =>
    view ? toScreen(view, size.value, note.x ?? 0, note.y ?? 0) : [-1, -1];
  return (
    <div class="note-pins" ref={layer}>
      <svg class="note-areas" aria-hidden="true">
        {view &&
          placed.map(({ id, outline }) =>
            outline ? (
              <polygon
                key={id}
                class={state.chosen.value === id ? "chosen" : undefined}
                points={outline.map(([x, y]) => toScreen(view, size.value, x, y).join(",")).join(" ")}
              />
            ) : null,
          )}
      </svg>
      {placed
        .map((note) => ({ note, at: place(note) }))
        .filter(({ at }) => isInside(at))
        .map(({ note, at: [x, y] }) => (
          <button
            key={note.id}
            type="button"
            class={state.chosen.value === note.id ? "note-pin chosen" : "note-pin"}
            style={{ transform: `translate(${x}px, ${y}px)` }}
            aria-label={`Note: ${note.text}`}
            title={note.text}
            onClick={() => {
              onOpen();
              goToNote(store, state, note);
            }}
          />
        ))}
    </div>
  );
}
