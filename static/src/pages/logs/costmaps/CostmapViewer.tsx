import { computed, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Picture } from "../../../render/picture/Picture";
import type { SharedView, View } from "../../../render/view";
import type { Store } from "../../../store/store";
import { CostFiles } from "../../../tools/costmap/CostFiles";
import { MapTools } from "../../../tools/measure/MapTools";
import { BeliefView } from "../../../tools/picture/BeliefView";
import { Dock } from "../../../ui/dock/Dock";
import { LiveRegion } from "../../../ui/LiveRegion";
import { written } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import { Select } from "../../../ui/Select";
import { timeText } from "../../../ui/text/timeText";
import { SessionEnded } from "../../SessionEnded";
import { useConnected } from "../../useConnected";
import { Head } from "../Head";
import { ShareLinks } from "../share/ShareLinks";
import { applySharedView, type GuestOfLink, sharedViewOf } from "../share/shown";
import { Transport } from "../Transport";
import { ViewerFrame, ViewerStatus } from "../ViewerFrame";
import "../../../tools/readout/readout.css";
import "../../../tools/costmap/costmap.css";
import "./costmaps.css";

/** A view of recorded costmaps as stored in an address. */
interface CostmapView {
  readonly topic: string;
  /** The number of the costmap, from 1. */
  readonly index: number;
  /** The visible part of the world; null: all of it. */
  readonly view: View | null;
}

/** A view as the fragment of an address. */
export function fragmentOf({ topic, index, view }: CostmapView): string {
  const query = new URLSearchParams({ costmap: String(index), topic });
  if (view) for (const [name, value] of Object.entries(view)) query.set(name, String(Number(value.toPrecision(6))));
  return `#${query}`;
}

/** The view in the fragment of an address; null if it has none. */
export function viewOf(fragment: string): CostmapView | null {
  const query = new URLSearchParams(fragment.slice(1));
  const index = Number(query.get("costmap"));
  const topic = query.get("topic");
  if (!Number.isInteger(index) || index < 1 || !topic) return null;
  const [x = Number.NaN, y = Number.NaN, scale = Number.NaN] = ["x", "y", "scale"].map((name) => {
    const text = query.get(name);
    return text ? Number(text) : Number.NaN;
  });
  const isView = Number.isFinite(x) && Number.isFinite(y) && Number.isFinite(scale) && scale > 0;
  return { topic, index, view: isView ? { x, y, scale } : null };
}

/** What the costs of Nav2's costmaps mean. Source: nav2_costmap_2d, cost_values.hpp. */
interface Meaning {
  /** The background that shows its colour on the map. */
  readonly token: string;
  readonly costs: readonly [first: number, last: number];
  readonly text: string;
}

const MEANINGS: readonly Meaning[] = [
  { token: "var(--map-free)", costs: [0, 0], text: "free" },
  {
    token: "linear-gradient(90deg, var(--cost-low), var(--cost-high))",
    costs: [1, 252],
    text: "near an obstacle",
  },
  { token: "var(--cost-inscribed)", costs: [253, 253], text: "inscribed: the robot touches an obstacle" },
  { token: "var(--cost-lethal)", costs: [254, 254], text: "lethal: an obstacle" },
  { token: "var(--map-unobserved)", costs: [255, 255], text: "no information" },
];

/** The cost of a cell's byte on the wire: byte 0 is no information, bytes 1 … 255 are 0 … 254. */
const costOf = (byte: number): number => (byte === 0 ? 255 : byte - 1);

/** The numbers of cells of a costmap in the ranges of {@link MEANINGS}, by the numbers of cells of each byte (256,). */
export function cellsByMeaning(bytes: Uint32Array, cells: number): readonly number[] {
  const known = MEANINGS.slice(0, -1).map(({ costs: [first, last] }) =>
    bytes.subarray(first + 1, last + 2).reduce((sum, count) => sum + count, 0),
  );
  return [...known, known.reduce((rest, count) => rest - count, cells)];
}

/** A cost in words. */
function meaningOf(cost: number): string {
  if (cost === 0) return "free";
  if (cost <= 252) return "near an obstacle";
  return { 253: "inscribed", 254: "lethal" }[cost] ?? "no information";
}

/** The cost of the inspected cell, as text of constant layout and for screen readers. */
function CostReadout({ store }: { readonly store: Store }) {
  const reading = useMemo(
    () =>
      computed(() => {
        const map = store.map.value;
        const cell = store.cell.value;
        void store.mapVersion.value;
        if (!map || !cell) return null;
        const cost = costOf(map.cells.at(cell.row, cell.col));
        return { row: cell.row, col: cell.col, cost, text: meaningOf(cost) };
      }),
    [store],
  );
  const now = reading.value;
  return (
    <div class="readout">
      <dl>
        <div>
          <dt>row</dt>
          <dd class="number">{now?.row ?? "–"}</dd>
        </div>
        <div>
          <dt>col</dt>
          <dd class="number">{now?.col ?? "–"}</dd>
        </div>
        <div>
          <dt>cost</dt>
          <dd class="number" data-cost={now?.cost}>
            {now?.cost ?? "–"}
          </dd>
        </div>
        <div class="readout-last">
          <dt class="visually-hidden">meaning</dt>
          <dd class="readout-state">{now?.text ?? "point at a cell"}</dd>
        </div>
      </dl>
      <LiveRegion text={now ? `Row ${now.row}, column ${now.col}: cost ${now.cost}, ${now.text}` : ""} />
    </div>
  );
}

const TEXT =
  "A link opens this costmap of the recording, with the visible part of it. Everyone who opens it gets a session of " +
  "their own, in which they can play the recording, read its costs and download each costmap. They cannot delete or " +
  "download the recording or open others. The link works until you revoke it.";

interface ShareCostmapProps {
  readonly store: Store;
  readonly session: string;
  /** The visible part of the costmap; null for all of it. */
  readonly sharedView: () => SharedView | null;
}

/** Links to the present view, and its address: the costmap, its topic, and the visible part. */
function ShareCostmap({ store, session, sharedView }: ShareCostmapProps) {
  const log = store.hello.value?.log;
  const frame = store.frame.value;
  if (!log || !frame) return null;
  const view = store.viewHeld.value ? store.view.value : null;
  const fragment = fragmentOf({ topic: log.trajectory, index: frame.index, view });
  const address = new URL(`?log=${encodeURIComponent(log.id)}${fragment}`, location.href).href;
  return (
    <ShareLinks session={session} sharedView={sharedView} unit="costmap" text={TEXT}>
      <label class="share-address">
        <span>For everyone who may open the recording on this service, its address:</span>
        <input
          class="field-text"
          readOnly
          aria-label="Address of this view"
          value={address}
          onFocus={(event) => event.currentTarget.select()}
        />
      </label>
    </ShareLinks>
  );
}

interface CostmapViewerProps {
  readonly session: string;
  /** Back to the logs; not for a guest. */
  readonly onClose?: () => void;
  /** The session has ended on the server: start another one on the same recording. */
  readonly onGone: () => void;
  readonly guest?: GuestOfLink;
}

/** The costmaps of a recording, one after the other. */
export function CostmapViewer({ session, onClose, onGone, guest }: CostmapViewerProps) {
  const picture = useRef<Picture | null>(null);
  const stage = useRef<HTMLDivElement>(null);
  const connection = useConnected(session, { picture });
  const { store, status, trouble } = connection;
  const openGroup = useSignal("costmap");
  const hello = store.hello.value;
  const isThere = hello !== null;
  useEffect(() => {
    if (isThere) showAddressed(store);
  }, [store, isThere]);
  useEffect(() => applySharedView(store, picture, guest?.view ?? null), [connection]);
  const ended = status.value === "gone";
  useEffect(() => {
    if (ended) guest?.onEnded();
  }, [ended]);
  if (ended) {
    return (
      <SessionEnded
        left="The recording is still there."
        again="Open the recording again"
        onAgain={onGone}
        back="All logs"
        onBack={onClose}
      />
    );
  }
  const share = {
    id: "share",
    title: "Share",
    keeps: true,
    badge: null,
    content: () => <ShareCostmap store={store} session={session} sharedView={() => sharedViewOf(store, picture)} />,
  };
  return (
    <ViewerFrame
      dock={
        <Dock
          label="About these costmaps"
          groups={[
            {
              id: "costmap",
              title: "Costmap",
              keeps: true,
              badge: null,
              content: () => <About store={store} session={session} />,
            },
            ...(guest ? [] : [share]),
          ]}
          open={openGroup}
        />
      }
    >
      <Head store={store} onClose={onClose} />
      <div class="viewer-stage" ref={stage}>
        <div class="viewer-map">
          <BeliefView
            store={store}
            onPicture={(made) => {
              picture.current = made;
            }}
          />
          <MapTools store={store} stage={stage} />
          <ViewerStatus hello={hello} trouble={trouble.value} opening="Opening the costmaps …" />
        </div>
        <Transport store={store} unit="costmap" />
        <div class="viewer-readout">
          <CostReadout store={store} />
        </div>
      </div>
    </ViewerFrame>
  );
}

/** Show the view in the address of the page once; then remove it. */
function showAddressed(store: Store): void {
  const shown = viewOf(location.hash);
  if (!shown) return;
  history.replaceState(null, "", location.pathname + location.search);
  if (shown.topic !== store.hello.peek()?.log?.trajectory) store.send({ type: "trajectory", name: shown.topic });
  store.goTo(shown.index);
  if (!shown.view) return;
  store.view.value = shown.view;
  store.viewHeld.value = true;
}

interface AboutProps {
  readonly store: Store;
  readonly session: string;
}

/** The topic and the recording, the cells of the present costmap by their meaning, and its files. */
function About({ store, session }: AboutProps) {
  const log = store.hello.value?.log ?? null;
  return (
    <>
      <Panel title="Costmap">
        {log && log.trajectories.length > 1 && (
          <label class="stack-tight">
            <span>Topic</span>
            <Select
              value={log.trajectory}
              options={log.trajectories.map(({ name }) => name)}
              onChange={(name) => store.send({ type: "trajectory", name })}
            />
          </label>
        )}
        <Facts store={store} />
      </Panel>
      <Panel title="Cells">
        <CellsByCost store={store} />
      </Panel>
      <Panel title="Download this costmap">
        <CostFiles session={session} />
      </Panel>
    </>
  );
}

/** The facts of the recording and of the present costmap: names, and values. */
function Facts({ store }: { readonly store: Store }) {
  const log = store.hello.value?.log;
  const geometry = store.map.value?.geometry;
  if (!log) return null;
  const { duration_s: duration, n_scans: count, start_s: start } = log;
  const metres = (cells: number): string => written(cells * (geometry?.resolution ?? 0), 1);
  const facts: readonly (readonly [name: string, value: string])[] = [
    ["Topic", `${log.trajectory}: ${log.trajectories.find(({ name }) => name === log.trajectory)?.description ?? ""}`],
    ...(duration > 0
      ? [
          ["Recorded", `${timeText(duration)}${start === null ? "" : `, from ${timeText(0, start)}`}`] as const,
          ["Rate", `${written((count - 1) / duration, 1)} a second`] as const,
        ]
      : []),
    ...(geometry
      ? [
          [
            "Size",
            `${metres(geometry.cols)} m × ${metres(geometry.rows)} m, ${geometry.cols} × ${geometry.rows} cells of ${geometry.resolution} m`,
          ] as const,
        ]
      : []),
  ];
  return (
    <dl class="log-facts" aria-label="Facts">
      {facts.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}

/** An area in m²: less than 1 m² to the area of a cell of 1 cm. */
const areaText = (area: number): string => `${written(area, area < 1 ? 4 : 2)} m²`;

/** What the colours mean, and how many cells of the present costmap have them. */
function CellsByCost({ store }: { readonly store: Store }) {
  const counts = useMemo(
    () =>
      computed(() => {
        const map = store.map.value;
        void store.mapVersion.value;
        return map && cellsByMeaning(map.cells.histogram(), map.geometry.rows * map.geometry.cols);
      }),
    [store],
  ).value;
  const cellArea = (store.map.value?.geometry.resolution ?? 0) ** 2;
  return (
    <table class="costmaps-key">
      <thead>
        <tr>
          <th scope="col">Cost</th>
          <th scope="col">Meaning</th>
          <th scope="col">Cells</th>
          <th scope="col">Area</th>
        </tr>
      </thead>
      <tbody>
        {MEANINGS.map(({ token, costs: [first, last], text }, n) => (
          <tr key={text}>
            <td class="number">
              <span class="costmaps-swatch" style={{ background: token }} aria-hidden="true" />
              {first === last ? first : `${first} … ${last}`}
            </td>
            <td>{text}</td>
            <td class="number">{counts?.[n]?.toLocaleString("en") ?? "–"}</td>
            <td class="number">{counts ? areaText((counts[n] ?? 0) * cellArea) : "–"}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
