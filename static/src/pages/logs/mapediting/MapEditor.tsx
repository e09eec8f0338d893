import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Picture } from "../../../render/picture/Picture";
import type { Store } from "../../../store/store";
import { MapView } from "../../../tools/mapediting/MapView";
import { mapEditingOf } from "../../../tools/mapediting/state";
import { Tools, WholeMap } from "../../../tools/mapediting/Tools";
import { Button } from "../../../ui/Button";
import { Dock } from "../../../ui/dock/Dock";
import { Icon } from "../../../ui/Icon";
import { Panel } from "../../../ui/Panel";
import { SessionEnded } from "../../SessionEnded";
import { useConnected } from "../../useConnected";
import { ViewerFrame } from "../ViewerFrame";
import { MapReadout } from "./MapReadout";
import { Saving } from "./Saving";

interface MapEditorProps {
  readonly session: string;
  readonly onClose: () => void;
  /** The session has ended on the server: begin another on the same map. */
  readonly onGone: () => void;
}

/** A map that is edited: painted, cropped, turned, and kept as a new map. */
export function MapEditor({ session, onClose, onGone }: MapEditorProps) {
  const picture = useRef<Picture | null>(null);
  const connection = useConnected(session, { picture });
  const { store, status, trouble } = connection;
  const openGroup = useSignal("edit");
  useEffect(() => listenForUndo(store), [store]);
  const hello = store.hello.value;
  if (status.value === "gone") {
    return (
      <SessionEnded
        left="The map is still there; edits that were not saved are lost."
        again="Open the map again"
        onAgain={onGone}
        back="All logs"
        onBack={onClose}
      />
    );
  }
  return (
    <ViewerFrame
      dock={
        <Dock
          label="Edit this map"
          groups={[
            { id: "edit", title: "Edit", keeps: true, badge: null, content: () => <Editing store={store} /> },
            {
              id: "save",
              title: "Save",
              keeps: true,
              badge: null,
              content: () => <Saving store={store} session={session} />,
            },
          ]}
          open={openGroup}
        />
      }
    >
      <header class="viewer-head">
        <Button kind="quiet" icon="back" label="All logs" onClick={onClose} />
        <h1>{hello?.title ?? "…"}</h1>
        <UndoRedo store={store} />
      </header>
      <div class="viewer-stage">
        <div class="viewer-map">
          <MapView
            store={store}
            onPicture={(made) => {
              picture.current = made;
            }}
          />
          {(!hello || trouble.value) && (
            <p class="viewer-over" role="status">
              {trouble.value ? <Icon name="warning" /> : null} {trouble.value ?? "Opening the map …"}
            </p>
          )}
          {store.working.value && (
            <p class="viewer-over" role="status">
              Editing the map …
            </p>
          )}
        </div>
        <div class="viewer-readout">
          <MapReadout store={store} />
        </div>
      </div>
    </ViewerFrame>
  );
}

function Editing({ store }: { readonly store: Store }) {
  const edits = mapEditingOf(store).edits.value;
  return (
    <>
      <Panel title="Draw">
        <Tools store={store} />
      </Panel>
      <Panel title="Whole map">
        <WholeMap store={store} />
      </Panel>
      <Panel title="Edits" note={edits && edits.n > 0 ? String(edits.n) : null}>
        {edits && edits.n > 0 ? (
          <ol class="mapediting-list" start={edits.n - edits.last.length + 1}>
            {edits.last.map((one, i) => (
              <li key={edits.n - edits.last.length + i}>{one}</li>
            ))}
          </ol>
        ) : (
          <p class="quiet">None yet. The map that you opened stays as it is; the edits make a new one.</p>
        )}
        {edits?.notes.map((note) => (
          <p class="quiet" key={note}>
            {note}
          </p>
        ))}
      </Panel>
    </>
  );
}

const step = (store: Store, steps: number): void => store.send({ type: "map_history", steps });

function UndoRedo({ store }: { readonly store: Store }) {
  const edits = mapEditingOf(store).edits.value;
  return (
    <div class="actions">
      <Button icon="undo" label="Undo (Ctrl+Z)" disabled={!edits?.n} onClick={() => step(store, -1)} />
      <Button icon="redo" label="Redo (Ctrl+Shift+Z)" disabled={!edits?.undone} onClick={() => step(store, 1)} />
    </div>
  );
}

/** Ctrl+Z and Ctrl+Shift+Z, or Ctrl+Y, except in a field; the returned function ends that. */
function listenForUndo(store: Store): () => void {
  const onKey = (event: KeyboardEvent): void => {
    const pressed = event.key.toLowerCase();
    const isField =
      event.target instanceof Element && event.target.closest("input:not([type=radio]), textarea") !== null;
    if (!(event.ctrlKey || event.metaKey) || event.altKey || isField || (pressed !== "z" && pressed !== "y")) return;
    event.preventDefault();
    step(store, pressed === "y" || event.shiftKey ? 1 : -1);
  };
  addEventListener("keydown", onKey);
  return () => removeEventListener("keydown", onKey);
}
