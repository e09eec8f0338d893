import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import { momentText, shownTime } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { FileButton } from "../../../tools/files/FileButton";
import { measuringOf } from "../../../tools/measure/measuring";
import { areaOf } from "../../../tools/measure/model";
import { Button } from "../../../ui/Button";
import { Failure } from "../../../ui/Failure";
import { written } from "../../../ui/numbers";
import { ToggleOf } from "../../../ui/Toggle";
import type { NoteAnswer } from "../../../wire/http";
import { type Pin, scanOf } from "./noteRecords";
import "./notes.css";
import type { NotesState } from "./useNotes";

/** Files of the notes for other programs. */
const FILES = [
  ["geojson", "GeoJSON"],
  ["csv", "CSV"],
] as const;

interface NotesProps {
  readonly store: Store;
  readonly session: string;
  readonly state: NotesState;
  readonly isGuest: boolean;
}

/** The notes on the log: written, edited and deleted here, and shown on the slider and on the map. */
export function Notes({ store, session, state, isGuest }: NotesProps) {
  const edited = useSignal<string | null>(null);
  useEffect(() => void state.refresh(), [state.notes]);
  const notes = state.notes.value;
  return (
    <div class="notes">
      {!isGuest && <Editor key="new" store={store} state={state} />}
      <Failure why={state.failure.value} />
      {notes?.length === 0 && <p class="quiet">There are no notes on this log yet.</p>}
      {notes !== null && notes.length > 0 && (
        <div class="actions">
          {FILES.map(([ending, label]) => (
            <FileButton
              key={ending}
              session={session}
              file={`notes.${ending}`}
              kind="quiet"
              label={`Download the notes as ${label}, coordinates in metres`}
            >
              {label}
            </FileButton>
          ))}
        </div>
      )}
      <ul aria-label="Notes">
        {notes?.map((note) => (
          <li key={note.id}>
            {edited.value === note.id ? (
              <Editor
                store={store}
                state={state}
                note={note}
                onDone={() => {
                  edited.value = null;
                }}
              />
            ) : (
              <Item
                note={note}
                store={store}
                state={state}
                onEdit={
                  note.mine
                    ? () => {
                        edited.value = note.id;
                      }
                    : undefined
                }
              />
            )}
          </li>
        ))}
      </ul>
    </div>
  );
}

/** Show the time and place of a note, and mark it as selected. */
export function goToNote(store: Store, { chosen }: NotesState, note: NoteAnswer): void {
  chosen.value = note.id;
  const scan = scanOf(note, store.trajectory.peek(), store.frame.peek()?.count ?? 0);
  if (scan !== null) store.goTo(scan);
  const view = store.view.peek();
  if (note.x !== null && note.y !== null && view) store.setView({ ...view, x: note.x, y: note.y });
}

interface ItemProps {
  readonly note: NoteAnswer;
  readonly store: Store;
  readonly state: NotesState;
  readonly onEdit: (() => void) | undefined;
}

function Item({ note, store, state, onEdit }: ItemProps) {
  const item = useRef<HTMLDivElement>(null);
  const isChosen = state.chosen.value === note.id;
  useEffect(() => {
    if (isChosen) item.current?.scrollIntoView({ block: "nearest" });
  }, [isChosen]);
  return (
    <div class={isChosen ? "note chosen" : "note"} ref={item}>
      <p class="note-text">{note.text}</p>
      <div class="note-foot">
        <Button
          kind="quiet"
          label={`Go to this note: ${pinLabel(store, note)}`}
          onClick={() => goToNote(store, state, note)}
        >
          {pinLabel(store, note)}
        </Button>
        {onEdit && (
          <>
            <Button kind="quiet" onClick={onEdit}>
              Edit
            </Button>
            <Button kind="quiet" icon="trash" label="Delete this note" onClick={() => void state.remove(note.id)} />
          </>
        )}
      </div>
    </div>
  );
}

function pinLabel(store: Store, { at_s, scan, x, y, outline }: Pin): string {
  const time = at_s === null ? [] : [at_s > 0 ? shownTime(store, at_s) : `scan ${scan}`];
  const place = x === null || y === null ? [] : [`${written(x, 2)}, ${written(y, 2)} m`];
  const area = outline === null ? [] : [`${written(areaOf(outline), 2)} m²`];
  return [...time, ...place, ...area].join(" · ");
}

/** Text of new notes that was not sent yet, by the id of the log: it outlasts a session that ends on the server. */
const drafts = new Map<string, string>();

interface EditorProps {
  readonly store: Store;
  readonly state: NotesState;
  /** The note being edited; null for a new one. */
  readonly note?: NoteAnswer;
  readonly onDone?: () => void;
}

function Editor({ store, state, note, onDone }: EditorProps) {
  const id = useId();
  const log = store.hello.value?.log?.id ?? "";
  const text = useSignal(note?.text ?? drafts.get(log) ?? "");
  useSignalEffect(() => {
    if (!note) drafts.set(log, text.value);
  });
  const hasTime = useSignal(note ? note.at_s !== null : true);
  const hasPlace = useSignal(note ? note.x !== null && note.outline === null : false);
  const hasArea = useSignal(note ? note.outline !== null : false);
  const busy = useSignal(false);
  const frame = store.frame.value;
  const pinned = store.pinned.value;
  const measuring = measuringOf(store);
  const measured = measuring.tool.value === "area" ? measuring.onMap.value : [];
  const area = note?.outline ?? (measured.length >= 3 && areaOf(measured) > 0 ? measured : null);
  // An existing pin of a note is kept. A new one is at the present time, or in the clicked cell.
  const pin: Pin = {
    at_s: hasTime.value ? (note?.at_s ?? frame?.stamp ?? 0) : null,
    scan: hasTime.value ? (note?.scan ?? frame?.index ?? 0) : null,
    x: hasPlace.value ? (note?.x ?? pinned?.[0] ?? null) : null,
    y: hasPlace.value ? (note?.y ?? pinned?.[1] ?? null) : null,
    outline: hasArea.value ? area : null,
  };
  const isPinned =
    (pin.at_s !== null || pin.x !== null || pin.outline !== null) &&
    (!hasPlace.value || pin.x !== null) &&
    (!hasArea.value || pin.outline !== null);
  const save = async (): Promise<void> => {
    busy.value = true;
    const sent = text.peek();
    if (await state.keep(sent.trim(), pin, note?.id)) {
      if (!note && text.peek() === sent) text.value = ""; // else it is the text of the next note already
      onDone?.();
    }
    busy.value = false;
  };
  return (
    <form
      class="note-editor"
      onSubmit={(event) => {
        event.preventDefault();
        void save();
      }}
    >
      <label for={id}>{note ? "Change the note" : "New note"}</label>
      <textarea
        class="field-text"
        id={id}
        rows={3}
        maxLength={2000}
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
        }}
      />
      <ToggleOf
        label={
          hasTime.value && note?.at_s != null
            ? `At ${shownTime(store, note.at_s)}`
            : `At this moment, ${momentLabel(store)}`
        }
        signal={hasTime}
      />
      <ToggleOf
        label={
          hasPlace.value && pin.x !== null && pin.y !== null
            ? `At ${written(pin.x, 2)}, ${written(pin.y, 2)} m on the map`
            : "At the cell that I click on the map"
        }
        signal={hasPlace}
      />
      <ToggleOf
        label={area ? `Around the area of ${written(areaOf(area), 2)} m²` : "Around the area that I measure on the map"}
        signal={hasArea}
      />
      {hasArea.value && !area && (
        <p class="quiet">Choose the area tool above the map, then click at least three corners.</p>
      )}
      <div class="actions">
        <Button
          kind="primary"
          disabled={busy.value || !isPinned || text.value.trim() === ""}
          onClick={() => void save()}
        >
          {note ? "Save" : "Add note"}
        </Button>
        {note && onDone && <Button onClick={onDone}>Cancel</Button>}
      </div>
    </form>
  );
}

function momentLabel(store: Store): string {
  const frame = store.frame.value;
  return frame ? momentText(store, frame.stamp, frame.index) : "…";
}
