/** The lab's 3D map: drawn while the robot drives, cut by height, its memory, and what the 2D map lacks. */

import { useEffect, useMemo } from "preact/hooks";
import { SurfaceProfile } from "../../lessons/tsdf/SurfaceProfile";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { Failure } from "../../ui/Failure";
import { plural, bytes as sizeOf } from "../../ui/numbers";
import type { Map3dMessage, SurfaceMessage, Value } from "../../wire/protocol";
import { CostmapOver } from "../costmap/CostmapOver";
import { FileButton } from "../files/FileButton";
import { ParameterRows } from "../parameters/ParameterRows";
import { Scene } from "../scene/Scene";
import { ClipBox, ClipHandles } from "../volume/ClipBox";
import type { Look } from "../volume/useLook";
import { VoxelWhy } from "../volume/VoxelWhy";
import { ClickChoice } from "./ClickChoice";
import { ONLY_IN_3D } from "./over";
import { useMap3dRows } from "./Sensor3d";
import "../volume/volume.css";
import "./map3d.css";

/** Bytes of an empty bar. */
const LEAST = 1000;

/** The share 0 … 1 of a bar on a logarithmic scale that ends at `most`. */
const shareOf = (bytes: number, most: number): number =>
  bytes <= LEAST || most <= LEAST ? 0 : Math.min(1, Math.log(bytes / LEAST) / Math.log(most / LEAST));

interface MemoryProps {
  readonly message: Map3dMessage;
  /** The displayed surface; null for none. */
  readonly surface: SurfaceMessage | null;
}

function Memory({ message, surface }: MemoryProps) {
  const { known, nodes, leaves, octree_bytes, block_bytes, dense_bytes, scans, taken } = message;
  const rows = [
    { name: "Octree", bytes: octree_bytes, what: `${nodes.toLocaleString("en")} nodes` },
    { name: "Blocks of 8³", bytes: block_bytes, what: `${known.toLocaleString("en")} known voxels` },
    ...(surface ? [{ name: "Signed distances", bytes: surface.bytes, what: "of blocks near surfaces" }] : []),
    { name: "Dense grid", bytes: dense_bytes, what: "of the whole world" },
  ];
  const most = Math.max(dense_bytes, block_bytes, 1);
  return (
    <section class="map3d-memory" aria-label="Memory of the 3D map">
      <dl>
        {rows.map(({ name, bytes, what }) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>
              <span class="map3d-bar" style={{ inlineSize: `${100 * shareOf(bytes, most)}%` }} aria-hidden="true" />
              <span class="map3d-bytes">
                {sizeOf(bytes)} · {what}
              </span>
            </dd>
          </div>
        ))}
      </dl>
      <p class="map3d-note">
        {scans < taken
          ? `The map is being computed again: ${scans} of ${taken} scans.`
          : `${scans} scans. Eight equal voxels are one node: ${leaves.toLocaleString("en")} leaves hold ${known.toLocaleString("en")} voxels.`}{" "}
        Bars are logarithmic.
      </p>
    </section>
  );
}

function SurfacePanel({ store }: { readonly store: Store }) {
  const rows = useMap3dRows(store, "tsdf_3d");
  const set = useMemo(() => (name: string, value: Value) => store.setPart("map3d", { [name]: value }), [store]);
  const { values } = store.part("map3d").values;
  return (
    <section class="surface-panel" aria-label="The same beam, two beliefs">
      <h3>The same beam, two beliefs</h3>
      <p class="map3d-note">
        20 readings of a wall, as occupied cells and as signed distances. Drag the truncation or the maximum weight: the
        surface is computed again.
      </p>
      <SurfaceProfile resolution={Number(values.value.voxel)} values={values.value} set={set} />
      <Facts store={store} />
      <div class="map3d-settings">
        <ParameterRows rows={rows} values={values} set={set} />
      </div>
    </section>
  );
}

function Facts({ store }: { readonly store: Store }) {
  const now = store.part("surface").message.value;
  if (!now) return <p class="map3d-note">The surface is being made …</p>;
  if (now.problem !== null) return <p role="alert">{now.problem}</p>;
  const many = (count: number): string => count.toLocaleString("en");
  return (
    <p class="map3d-note surface-facts">
      <b>{many(now.triangles)}</b> triangles of {many(now.index)} scans, in {many(now.blocks)} blocks of 8³ voxels.
    </p>
  );
}

/** The world with a low table, a ramp and stairs. */
const LEVELS = "levels";

const KINDS = [
  { value: "occupancy", label: "Occupancy" },
  { value: "tsdf", label: "TSDF" },
];

/** The clip box, within the bounds of the world. */
function useClip(store: Store): Look {
  const rows = useMap3dRows(store, "clip_3d");
  const bounds = store.world.value?.bounds;
  return useMemo(
    () => ({
      rows: rows.map((row) => {
        const axis = ["cut_x", "cut_y"].findIndex((name) => row.name.startsWith(name));
        const [low, high] = [bounds?.[axis], bounds?.[axis + 2]];
        return low === undefined || high === undefined ? row : { ...row, low, high };
      }),
      values: store.part("map3d").values.values,
      set: (name, value) => store.setPart("map3d", { [name]: value }),
      setAll: (values) => store.setPart("map3d", values),
    }),
    [store, rows, bounds],
  );
}

interface GroupProps {
  readonly store: Store;
  readonly session: string;
}

export function Map3dGroup({ store, session }: GroupProps) {
  const { layers } = store;
  const map3d = store.part("map3d");
  const message = map3d.message.value;
  const isOn = message?.is_on === true;
  const isEnded = map3d.isEnded.value;
  const [kind] = useMap3dRows(store, "kind_3d");
  const map = useMap3dRows(store, "map_3d");
  const view = useMap3dRows(store, "view_3d");
  const clip = useClip(store);
  const band = useMap3dRows(store, "band_3d");
  const set = useMemo(() => (name: string, value: Value) => store.setPart("map3d", { [name]: value }), [store]);
  useEffect(() => {
    if (!isOn && !isEnded && map3d.message.peek()) store.send({ type: "map3d" });
  }, [store, isOn, isEnded, message === null]);
  useEffect(() => {
    if (!isOn) return undefined;
    map3d.isOver.value = true;
    const end = layers.subscribe(ONLY_IN_3D);
    return () => {
      map3d.isOver.value = false;
      end();
    };
  }, [store, isOn]);
  if (!isOn || !message) return <Begin store={store} />;
  const { values } = map3d.values;
  const isSurface = values.value.kind === "tsdf";
  return (
    <div class="map3d stack-narrow">
      {/* First, so that it is visible in a panel of 200 px, because the tabs above it take as much. */}
      <div class="map3d-view">
        <Scene store={store} session={session} hasColumns={false} actions={<ClipHandles look={clip} />} />
      </div>
      <Choice
        label="Map"
        sentence={kind?.sentence ?? ""}
        options={KINDS}
        value={String(values.value.kind)}
        onChange={(value) => set("kind", value)}
      />
      {isSurface && <SurfacePanel store={store} />}
      <ClickChoice store={store} />
      <Difference store={store} />
      <div class="map3d-why">
        <VoxelWhy store={store} />
      </div>
      <div class="map3d-settings">
        <ParameterRows rows={map} values={values} set={set} />
      </div>
      <Memory message={message} surface={isSurface ? store.part("surface").message.value : null} />
      <h3>What is drawn</h3>
      <div class="map3d-settings">
        <ParameterRows rows={view} values={values} set={set} />
      </div>
      <ClipBox look={clip} />
      <h3>The map from above</h3>
      <div class="map3d-settings">
        <ParameterRows rows={band} values={values} set={set} />
      </div>
      <CostmapOver
        store={store}
        map="map_3d"
        label="Costmap over the 3D map"
        title="The static layer of the costmap is the 3D map from above; the group Costmap shows it, Path plans on it."
      />
      <h3>Download</h3>
      <Files session={session} isSurface={isSurface} />
      <Button
        kind="quiet"
        onClick={() => {
          map3d.isEnded.value = true;
          store.send({ type: "map3d", value: false });
        }}
      >
        End the 3D map
      </Button>
    </div>
  );
}

function Begin({ store }: { readonly store: Store }) {
  if (!store.part("map3d").isEnded.value) return <p class="map3d-note">Starting the 3D map …</p>;
  return (
    <Button
      kind="primary"
      onClick={() => {
        store.part("map3d").isEnded.value = false;
      }}
    >
      Begin a 3D map
    </Button>
  );
}

/** What the 3D map contains that the 2D map lacks, and where. */
function Difference({ store }: { readonly store: Store }) {
  const message = store.part("map3d").message.value;
  if (!message) return null;
  const { only_in_3d: cells, problem } = message;
  const isElsewhere = store.world.value?.name !== LEVELS;
  return (
    <div class="map3d-difference">
      <Failure why={problem} />
      <p role="status">
        <span class="map3d-key" aria-hidden="true" />
        <b>{plural(cells, "cell")}</b> {cells === 1 ? "is an obstacle" : "are obstacles"} of the 3D map that the 2D map
        lacks; the belief shows {cells === 1 ? "it" : "them"} in this colour.
      </p>
      {isElsewhere && (
        <Button kind="quiet" onClick={() => store.chooseWorld(LEVELS)}>
          Try the room with a low table
        </Button>
      )}
    </div>
  );
}

const FILES = ["volume.bt", "volume.ot", "surface.ply", "surface.glb", "above.pgm", "above.yaml"] as const;

interface FilesProps {
  readonly session: string;
  /** Whether the surface is shown instead of the voxels. */
  readonly isSurface: boolean;
}

function Files({ session, isSurface }: FilesProps) {
  return (
    <>
      <div class="actions">
        {FILES.map((name) => (
          <FileButton key={name} session={session} file={name}>
            {name.split(".")[1]}
          </FileButton>
        ))}
      </div>
      <p class="map3d-note">
        bt and ot are octrees for OctoMap, ply and glb {isSurface ? "the surface" : "the outside of the voxels"} as
        triangles, pgm and yaml the map from above, of the band of heights, for map_server.
      </p>
    </>
  );
}
