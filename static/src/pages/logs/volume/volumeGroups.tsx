/** The groups of the dock beside a 3D map. A new group is one entry of `GROUPS`. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { SurfaceProfile } from "../../../lessons/tsdf/SurfaceProfile";
import type { Store } from "../../../store/store";
import { FileButton } from "../../../tools/files/FileButton";
import { MapFiles } from "../../../tools/files/MapFiles";
import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { groupsOfParts } from "../../../tools/parts";
import { BeliefView } from "../../../tools/picture/BeliefView";
import { LookGroup } from "../../../tools/volume/LookGroup";
import { lookOf, useLook } from "../../../tools/volume/useLook";
import { VoxelWhy } from "../../../tools/volume/VoxelWhy";
import { Button } from "../../../ui/Button";
import { selected } from "../../../ui/bound";
import type { DockGroup } from "../../../ui/dock/Dock";
import { bytes } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import { Select, SelectField } from "../../../ui/Select";
import { ask } from "../../../wire/ask";
import type { Value, VolumeMessage } from "../../../wire/protocol";
import type { LogRecord } from "../library/library";

interface VolumeCompareProps {
  readonly store: Store;
  readonly log: string | null;
  readonly onCompare: (other: string | null) => void;
}

/** The comparison with an earlier state of the map, or with another file. */
function VolumeCompare({ store, log, onCompare }: VolumeCompareProps) {
  const others = useSignal<readonly LogRecord[]>([]);
  const chosen = useSignal("");
  useEffect(() => {
    void ask("GET /api/logs", {}, { query: { limit: 200 } })
      .then((answer) => {
        others.value = answer.logs.filter((other) => other.clouds > 0 && other.state === "ready" && other.id !== log);
      })
      .catch(() => undefined);
  }, [log]);
  const compared = store.part("volume").message.value?.compared ?? null;
  const frame = store.frame.value;
  return (
    <Panel title="Compare">
      {frame && frame.count > 1 && (
        <>
          <div class="actions">
            <Button onClick={() => store.send({ type: "volume_keep" })}>Keep the map of {frame.index} scans</Button>
          </div>
          <p class="quiet">Then move along the timeline: what differs from the kept map is drawn.</p>
        </>
      )}
      {others.value.length > 0 && (
        <div class="volume-other">
          <label>
            <span>Another file</span>
            <Select
              {...selected(chosen)}
              options={[
                { value: "", label: "choose one" },
                ...others.value.map(({ id, name }) => ({ value: id, label: name })),
              ]}
            />
          </label>
          <Button disabled={chosen.value === ""} onClick={() => onCompare(chosen.value)}>
            Compare
          </Button>
        </div>
      )}
      {compared ? <Changes compared={compared} /> : <p class="quiet">No other map is compared with this one.</p>}
      {compared && (
        <div class="actions">
          <Button onClick={() => store.send({ type: "volume_keep", value: false })}>End the comparison</Button>
        </div>
      )}
    </Panel>
  );
}

function Changes({ compared }: { readonly compared: NonNullable<VolumeMessage["compared"]> }) {
  const rows: readonly (readonly [label: string, count: number, swatch: string])[] = [
    ["appeared: free before, occupied now", compared.appeared, "added"],
    ["vanished: occupied before, free now", compared.vanished, "removed"],
    ["the same in both", compared.same, ""],
    ["known in the other map only", compared.only_first, ""],
    ["known in this map only", compared.only_second, ""],
  ];
  return (
    <>
      <p>Compared with {compared.title}, in voxels:</p>
      <ul class="volume-changes" data-appeared={compared.appeared} data-vanished={compared.vanished}>
        {rows.map(([label, count, swatch]) => (
          <li key={label}>
            <span class={`volume-swatch ${swatch}`} aria-hidden="true" />
            <span class="number">{count.toLocaleString("en")}</span>
            <span>{label}</span>
          </li>
        ))}
      </ul>
    </>
  );
}

/** The surface from truncated signed distances: its parameters, and the effect of one beam. */
function SurfaceGroup({ store }: { readonly store: Store }) {
  const now = store.part("surface").message.value;
  if (!now) return null;
  if (now.table.length === 0) {
    return (
      <p class="quiet">
        A surface is made of distances along beams. The file does not say where its sensor was, so there are none.
      </p>
    );
  }
  const values = store.part("surface").values.values;
  const set = (name: string, value: Value): void => {
    store.part("surface").values.set(name, value);
    store.sendSoon({ type: "surface", values: { [name]: value } });
  };
  const isShown = lookOf(store).values.value.show === "surface";
  const resolution = Number(values.value.resolution);
  return (
    <>
      {!isShown && (
        <div class="actions">
          <Button
            kind="primary"
            onClick={() => {
              lookOf(store).set("show", "surface");
              store.send({ type: "volume_look", values: { show: "surface" } });
            }}
          >
            Show the surface
          </Button>
        </div>
      )}
      <Panel title="One beam, two maps">
        <p class="quiet">
          20 readings of a wall at {resolution} m voxels. Drag the truncation or the maximum weight: this surface is
          made again with it.
        </p>
        <SurfaceProfile resolution={resolution} values={values.value} set={set} />
      </Panel>
      <Panel title="Signed distances">
        <ParameterRows rows={now.table} values={values} set={set} />
      </Panel>
      {isShown && (
        <p class="quiet">
          {now.blocks.toLocaleString("en")} blocks of 8 × 8 × 8 voxels, {bytes(now.bytes)}.
          {now.snapshots.length > 0 && ` Kept to go back to: after scan ${now.snapshots.join(", ")}.`}
        </p>
      )}
    </>
  );
}

/** The parameters of the map, and its size. */
function VolumeMapGroup({ store }: { readonly store: Store }) {
  const table = store.hello.value?.parameters.table ?? [];
  const notes = store.hello.value?.log?.notes ?? [];
  return (
    <>
      <Panel title="Voxels">
        {table.length === 0 ? (
          <p class="quiet">An octree has no scans: its voxels cannot be made again.</p>
        ) : (
          <ParameterRows
            rows={table}
            values={store.mapping.values}
            set={(name, value) => store.setParameter(name, value)}
          />
        )}
      </Panel>
      <Memory store={store} />
      {notes.length > 0 && (
        <Panel title="Notes on the file">
          <ul class="volume-notes">
            {notes.map((note) => (
              <li key={note}>{note}</li>
            ))}
          </ul>
        </Panel>
      )}
    </>
  );
}

/** The octree beside a dense grid of the same box. */
function Memory({ store }: { readonly store: Store }) {
  const now = store.part("volume").message.value;
  if (!now) return null;
  return (
    <Panel title="Memory">
      <dl class="volume-memory number">
        <dt>Octree</dt>
        <dd>
          {now.nodes === null ? "…" : `${now.nodes.toLocaleString("en")} nodes, ${bytes(5 * now.nodes)} as a file .ot`}
        </dd>
        <dt>Blocks of 8 × 8 × 8</dt>
        <dd>{bytes(now.bytes)}</dd>
        <dt>Dense grid</dt>
        <dd>{bytes(now.dense_bytes)}</dd>
      </dl>
      <p class="quiet">
        A dense grid has four bytes for each voxel of the box around the points. The octree joins eight equal voxels,
        again and again: large free regions are single nodes.
      </p>
    </Panel>
  );
}

/** The map as an octree and from above. */
function VolumeDownloads({ store, session }: { readonly store: Store; readonly session: string }) {
  const hasSurface = (store.part("surface").message.value?.table.length ?? 0) > 0;
  return (
    <Panel title="Download">
      <div class="actions downloads">
        <FileButton session={session} file="volume.bt">
          bt
        </FileButton>
        <FileButton session={session} file="volume.ot">
          ot
        </FileButton>
        <MapFiles session={session} />
        <FileButton session={session} file="selection.ply">
          points in the clip box
        </FileButton>
        {hasSurface && (
          <>
            <FileButton session={session} file="surface.ply">
              ply
            </FileButton>
            <FileButton session={session} file="surface.glb">
              glb
            </FileButton>
          </>
        )}
      </div>
      <p class="quiet">
        bt and ot are octrees for OctoMap: bt has free and occupied voxels, ot their log-odds. pgm and yaml together are
        the map from above for map_server and Nav2.
        {hasSurface && " ply and glb are the surface as triangles with normals, for MeshLab, Blender and others."}
      </p>
    </Panel>
  );
}

const BAND = ["band_low", "band_high"];

/** The map from above, of a band of heights or a slice, and its files. */
function VolumeAbove({ store, session }: { readonly store: Store; readonly session: string }) {
  const look = useLook(store);
  if (!look) return null;
  const { rows, values, set } = look;
  const low = Number(values.value.band_low);
  const high = Number(values.value.band_high);
  const [first, last] = BAND.map((name) => rows.find((row) => row.name === name));
  return (
    <div class="volume-above stack">
      <div class="volume-above-map">
        <BeliefView store={store} />
      </div>
      <ParameterRows rows={rows.filter(({ name }) => BAND.includes(name))} values={values} set={set} />
      <div class="actions">
        <Button
          onClick={() => {
            const middle = Math.round(50 * (low + high)) / 100;
            store.send({ type: "volume_look", values: { band_low: middle, band_high: middle } });
          }}
        >
          Slice in the middle
        </Button>
        <Button
          onClick={() =>
            store.send({
              type: "volume_look",
              values: { band_low: first?.initial ?? low, band_high: last?.initial ?? high },
            })
          }
        >
          All heights
        </Button>
        <MapFiles session={session} />
      </div>
    </div>
  );
}

const AXES = ["z", "-z", "y", "-y", "x", "-x"] as const;

export type Axis = (typeof AXES)[number];

interface UpChoiceProps {
  readonly store: Store;
  readonly onUp: (axis: Axis) => void;
}

/** The axis of the file that points up: for depth cameras and scanners it often is not z. */
function UpChoice({ store, onUp }: UpChoiceProps) {
  const now = store.part("volume").message.value;
  if (!now?.has_scans) return null;
  return (
    <Panel title="Up">
      <SelectField
        title="Axis of the file that points up"
        value={AXES.find((axis) => axis === now.up) ?? "z"}
        options={AXES.map((axis) => ({ value: axis, label: axis.replace("-", "−") }))}
        onChange={onUp}
      />
      <p class="quiet">The map is opened again, turned.</p>
    </Panel>
  );
}

/** What the groups display. */
interface VolumeView {
  readonly store: Store;
  readonly session: string;
  /** The id of the map's log; null if unknown. */
  readonly log: string | null;
  readonly onCompare: (other: string | null) => void;
  /** Open the file again with another axis up; null if that is impossible. */
  readonly onUp: ((axis: Axis) => void) | null;
}

interface Group {
  readonly id: string;
  readonly title: string;
  /** The section that it shares with neighbouring groups. */
  readonly section?: string;
  readonly purpose: string;
  readonly content: (view: VolumeView) => ComponentChildren;
}

const GROUPS: readonly Group[] = [
  {
    id: "look",
    title: "View",
    purpose: "Which part of the map is drawn, and what the colours mean.",
    content: ({ store, onUp }) => (
      <>
        <LookGroup store={store} />
        {onUp && <UpChoice store={store} onUp={onUp} />}
      </>
    ),
  },
  {
    id: "map",
    title: "Map",
    section: "Mapping",
    purpose: "How the points become voxels. After a change the map is made again from all of its points.",
    content: ({ store }) => <VolumeMapGroup store={store} />,
  },
  {
    id: "surface",
    title: "Surface",
    section: "Mapping",
    purpose: "Where the surface is, between voxels: each keeps its mean signed distance to it.",
    content: ({ store }) => <SurfaceGroup store={store} />,
  },
  {
    id: "why",
    title: "Why",
    purpose: "Click a voxel to see which beams gave it its value.",
    content: ({ store }) => <VoxelWhy store={store} />,
  },
  {
    id: "above",
    title: "From above",
    section: "Ground",
    purpose: "The map for a driving robot: a cell is occupied if a voxel of its column is, within a band of heights.",
    content: ({ store, session }) => <VolumeAbove store={store} session={session} />,
  },
  ...groupsOfParts("volume", "Ground"),
  {
    id: "compare",
    title: "Compare",
    purpose: "What appeared and vanished since an earlier moment, or between two files of one place.",
    content: ({ store, log, onCompare }) => <VolumeCompare store={store} log={log} onCompare={onCompare} />,
  },
  {
    id: "download",
    title: "Download",
    purpose: "The map as files.",
    content: ({ store, session }) => <VolumeDownloads store={store} session={session} />,
  },
];

/** The groups for the dock. */
export function volumeGroups(view: VolumeView): readonly DockGroup[] {
  return GROUPS.map(({ content, ...group }) => ({ ...group, content: () => content(view) }));
}
