import { computed, signal, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { stateAt } from "../../../grid/cellValues";
import { centreOf } from "../../../grid/lattice";
import { costOfByte } from "../../../render/map/costColours";
import type { Picture } from "../../../render/picture/Picture";
import { pictureColours } from "../../../render/picture/pictureColours";
import type { Store } from "../../../store/store";
import { SPEED_LIMITS } from "../../../tools/costmap/paint";
import { FileButton } from "../../../tools/files/FileButton";
import { mapAddress } from "../../../tools/mapediting/EditMap";
import { paintEditing, watchEditing, ZONES, zonesOver } from "../../../tools/mapediting/paint";
import { mapEditingOf } from "../../../tools/mapediting/state";
import { key, stroke } from "../../../tools/mapediting/strokes";
import { Tools, WholeMap } from "../../../tools/mapediting/Tools";
import { MapTools } from "../../../tools/measure/MapTools";
import { measuringOf } from "../../../tools/measure/measuring";
import { paintMeasuring, watchMeasuring } from "../../../tools/measure/part";
import { measuringTool } from "../../../tools/measure/tool";
import { LinkedPicture } from "../../../tools/picture/LinkedPicture";
import { mapSurface } from "../../../tools/picture/mapSurface";
import { Button } from "../../../ui/Button";
import { useAttempts } from "../../../ui/browser/attempts";
import { Dock } from "../../../ui/dock/Dock";
import { Failure } from "../../../ui/Failure";
import { LiveRegion } from "../../../ui/LiveRegion";
import { Panel } from "../../../ui/Panel";
import { ask } from "../../../wire/ask";
import { SessionEnded } from "../../SessionEnded";
import { useConnected } from "../../useConnected";
import { Head } from "../Head";
import type { LogRecord } from "../library/library";
import { ViewerFrame, ViewerStatus } from "../ViewerFrame";
import "../../../tools/readout/readout.css";

interface SavingProps {
  readonly store: Store;
  readonly session: string;
}

/** Saves the edited map as a new one of the library, with links to its files. */
export function Saving({ store, session }: SavingProps) {
  const title = store.hello.value?.title ?? "map";
  const typed = useSignal<string | null>(null);
  const { isBusy, failure, attempt } = useAttempts();
  const saved = useSignal<LogRecord | null>(null);
  const name = typed.value ?? `${title}, edited`.slice(0, 100);
  const at = { session_id: session };
  const { edits } = mapEditingOf(store);
  const save = (): Promise<void> =>
    attempt(async () => {
      saved.value = null;
      saved.value = await ask("POST /api/sessions/{session_id}/edited-map", at, { body: { name: name.trim() } });
    });
  const geometry = store.map.value?.geometry;
  const files = [
    ["map.pgm", "pgm"],
    ["map.yaml", "yaml"],
    ...((edits.value?.keepout_cells ?? 0) > 0
      ? ([
          ["keepout.pgm", "Keepout pgm"],
          ["keepout.yaml", "Keepout yaml"],
        ] as const)
      : []),
    ...((edits.value?.speed_cells ?? 0) > 0
      ? ([
          ["speed.pgm", "Speed pgm"],
          ["speed.yaml", "Speed yaml"],
        ] as const)
      : []),
    ...(edits.value?.n ? ([["edits.json", "Edits"]] as const) : []),
  ] as const;
  return (
    <>
      <Panel title="Save as a new map">
        <form
          class="stack-narrow"
          onSubmit={(event) => {
            event.preventDefault();
            void save();
          }}
        >
          <label class="stack-tight">
            <span class="field-label">Name</span>
            <input
              class="field-text"
              type="text"
              maxLength={100}
              required
              value={name}
              onInput={(event) => {
                typed.value = event.currentTarget.value;
              }}
            />
          </label>
          <div class="actions">
            <button class="button primary" type="submit" disabled={isBusy.value || name.trim() === ""}>
              {isBusy.value ? "Saving …" : "Save"}
            </button>
          </div>
        </form>
        {saved.value && (
          <div class="mapediting-saved" role="status">
            <p>
              Saved as <b>{saved.value.name}</b>, among the logs. To find the robot of a log in it, open the log,
              “Localize”, and choose this map.
            </p>
            <div class="actions">
              <Button href={mapAddress(saved.value.id)} icon="map">
                Open it
              </Button>
            </div>
          </div>
        )}
        <Failure class="failure" why={failure.value} />
      </Panel>
      <Panel title="Download">
        <div class="stack-narrow">
          <div class="actions">
            {files.map(([file, label]) => (
              <FileButton key={file} session={session} file={`edited-map/${file}`}>
                {label}
              </FileButton>
            ))}
          </div>
          {geometry && (
            <p class="quiet number">
              {geometry.cols} × {geometry.rows} cells of {Number(geometry.resolution.toFixed(4))} m, origin{" "}
              {geometry.origin.map((value) => value.toFixed(2)).join(", ")}
            </p>
          )}
          <p class="quiet">
            pgm and yaml together are a map for map_server and Nav2; the keepout and speed files are the masks of Nav2’s
            keepout filter and speed filter, the latter in percent (type 1, base 0, multiplier 1). “gridbloom edit”
            applies the file of edits to a map.
          </p>
        </div>
      </Panel>
    </>
  );
}

interface MapViewProps {
  readonly store: Store;
  /** Called with the picture. */
  readonly onPicture?: (picture: Picture) => void;
}

/** The picture of the edited map. */
function MapView({ store, onPicture }: MapViewProps) {
  const failure = useMemo(() => signal(""), []);
  const shown = useRef(0);
  const [editing, measuring] = [mapEditingOf(store), measuringOf(store)];
  const ruler = useMemo(() => measuringTool(store), [store]);
  useEffect(() => store.layers.subscribe(ZONES), [store]);
  useEffect(() => store.layers.subscribe(SPEED_LIMITS), [store]);
  useSignalEffect(() => {
    // A rotation, a crop or another origin moves the map.
    const epoch = store.map.value?.geometry.epoch ?? 0;
    if (shown.current !== 0 && epoch !== shown.current) {
      store.viewHeld.value = false;
      measuring.clear();
    }
    shown.current = epoch;
  });
  // One tool receives the clicks: selecting the ruler deselects the brush, and vice versa.
  useSignalEffect(() => {
    if (measuring.tool.value !== null) editing.choose(null);
  });
  useSignalEffect(() => {
    if (editing.tool.value !== null) measuring.take(null);
  });
  return (
    <LinkedPicture
      store={store}
      label="The map. Arrow keys move the cell cursor, Enter uses the tool there, Escape puts it away; square brackets change the brush, plus and minus zoom, 0 shows everything."
      onTap={(point) => {
        store.pinned.value = store.pinned.peek() ? null : point;
      }}
      tool={{
        draws: () => editing.tool.peek() !== null,
        stroke: (from, to, isDone) => stroke(store, from, to, isDone),
        tap: ruler.tap,
        key: (pressed) => ruler.key(pressed) || key(store, pressed),
      }}
      {...(onPicture ? { onPicture } : {})}
      setUp={(canvas, invalidate) => {
        const surface = mapSurface(
          store,
          canvas,
          invalidate,
          () => [{ map: store.map.peek() }, ...zonesOver(store)],
          (brush) => {
            paintEditing(store, brush);
            paintMeasuring(store, brush);
            return false;
          },
        );
        failure.value = surface.failure;
        return {
          watch: () => {
            void [store.map.value, store.mapVersion.value, store.probe.value, pictureColours.value];
            watchEditing(store);
            watchMeasuring(store);
          },
          paint: surface.paint,
        };
      }}
    >
      {failure.value && <p class="picture-failure">{failure.value}</p>}
    </LinkedPicture>
  );
}

/** The inspected cell of a map, as text of constant layout and for screen readers. */
function MapReadout({ store }: { readonly store: Store }) {
  const reading = useMemo(
    () =>
      computed(() => {
        const map = store.map.value;
        const cell = store.cell.value;
        void store.mapVersion.value;
        if (!map || !cell) return null;
        const zones = store.layers.grid(ZONES).map.value;
        const isForbidden = zones !== null && zones.cells.at(cell.row, cell.col) > 0;
        const state = stateAt(map.cells.at(cell.row, cell.col), map.geometry);
        const [x, y] = centreOf(map.geometry, cell);
        const limits = store.layers.grid(SPEED_LIMITS).map.value;
        const limit = limits ? costOfByte(limits.cells.at(cell.row, cell.col)) : 0;
        const words = [
          state,
          ...(isForbidden ? ["keepout"] : []),
          ...(limit > 0 && limit <= 100 ? [`speed ${limit} %`] : []),
        ];
        return { x: x.toFixed(2), y: y.toFixed(2), text: words.join(", ") };
      }),
    [store],
  );
  const now = reading.value;
  return (
    <div class="readout">
      <dl>
        <div>
          <dt>x (m)</dt>
          <dd class="number">{now?.x ?? "–"}</dd>
        </div>
        <div>
          <dt>y (m)</dt>
          <dd class="number">{now?.y ?? "–"}</dd>
        </div>
        <div class="readout-last">
          <dt class="visually-hidden">state</dt>
          <dd class="readout-state" data-state={now?.text}>
            {now?.text ?? "point at a cell"}
          </dd>
        </div>
      </dl>
      <LiveRegion text={now && store.pinned.value ? `x ${now.x}, y ${now.y}: ${now.text}` : ""} />
    </div>
  );
}

interface MapEditorProps {
  readonly session: string;
  readonly onClose: () => void;
  /** The session has ended on the server: start another one on the same map. */
  readonly onGone: () => void;
}

/** A map that is edited: painted, cropped, rotated, and saved as a new map. */
export function MapEditor({ session, onClose, onGone }: MapEditorProps) {
  const picture = useRef<Picture | null>(null);
  const stage = useRef<HTMLDivElement>(null);
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
      <Head store={store} onClose={onClose}>
        <UndoRedo store={store} />
      </Head>
      <div class="viewer-stage" ref={stage}>
        <div class="viewer-map">
          <MapView
            store={store}
            onPicture={(made) => {
              picture.current = made;
            }}
          />
          <MapTools store={store} stage={stage} />
          <ViewerStatus hello={hello} trouble={trouble.value} opening="Opening the map …" />
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
            {edits.last.map((edit, i) => (
              <li key={edits.n - edits.last.length + i}>{edit}</li>
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

/** Ctrl+Z and Ctrl+Shift+Z, or Ctrl+Y, except in a text field. The returned function ends that. */
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
