/** The terrain from the robot's 3D sensor: classes over the map, κ, windows, and a queried patch. */

import { useEffect, useMemo } from "preact/hooks";
import { AskedPatch } from "../../lessons/terrain/AskedPatch";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import type { TerrainMessage } from "../../wire/messages";
import type { Parameter, Value } from "../../wire/protocol";
import { ParameterRows, useTable } from "../parameters/ParameterRows";
import "./terrain.css";
import { CostmapOver } from "../costmap/CostmapOver";
import { BeliefView } from "../picture/BeliefView";

/** The terrain of a file's points: the map from above in the colours of its patches, and their parameters. */
export function FileTerrain({ store }: { readonly store: Store }) {
  const hasPoints = store.part("volume").message.value?.has_scans ?? true;
  useEffect(
    () => () => {
      store.pinned.value = null;
    },
    [store],
  );
  if (!hasPoints) return <p class="quiet">An octree has no points: terrain is computed from a cloud.</p>;
  return (
    <div class="volume-above volume-terrain stack">
      <h2 class="visually-hidden">Terrain</h2>
      <div class="volume-above-map">
        <BeliefView store={store} />
      </div>
      <TerrainGroup store={store} isFile />
    </div>
  );
}

const COSTS = "terrain_costs";
const VALUES = "terrain_values";
const isProperty = (shown: Value | undefined): boolean => shown !== "costs" && shown !== "costmap";

interface GroupProps {
  readonly store: Store;
  /** For a file, whose points exist; otherwise they are those of the lab's 3D map. */
  readonly isFile?: boolean;
}

export function TerrainGroup({ store, isFile = false }: GroupProps) {
  const { layers } = store;
  const [terrain, map3d] = [store.part("terrain"), store.part("map3d")];
  const message = terrain.message.value;
  const isOn = message?.is_on === true;
  const hasPoints = isFile ? message !== null : (map3d.message.value?.taken ?? 0) > 0;
  const isEnded = terrain.isEnded.value;
  const view = useTable(store, "terrain", (row) => row.group === "terrain_view");
  const patches = useTable(store, "terrain", (row) => row.group === "terrain_patches");
  const ground = useTable(store, "terrain", (row) => row.group === "terrain_ground");
  const set = useMemo(() => (name: string, value: Value) => store.setPart("terrain", { [name]: value }), [store]);
  const shown = isProperty(terrain.values.values.value.shown) ? VALUES : COSTS;
  useEffect(() => {
    if (isEnded || isOn) return;
    if (hasPoints) store.send({ type: "terrain" });
    else if (map3d.message.peek()?.is_on === false) store.send({ type: "map3d" });
  }, [store, isOn, isEnded, hasPoints, map3d.message.value === null]);
  useEffect(() => {
    if (!isOn) return undefined;
    store.underlay.value = shown;
    const end = layers.subscribe(shown);
    return () => {
      store.underlay.value = null;
      end();
    };
  }, [store, isOn, shown]);
  // A click on the map queries the patch there.
  const pinned = store.pinned.value;
  useEffect(() => {
    if (isOn && pinned) store.send({ type: "terrain", x: pinned[0], y: pinned[1] });
  }, [store, isOn, pinned]);
  if (!isOn || !message) return <Begin store={store} />;
  const { values } = terrain.values;
  return (
    <div class="terrain-group stack-narrow">
      <Numbers message={message} isFile={isFile} rows={[...patches, ...ground]} />
      <AskedPatch message={message} />
      <ParameterRows rows={view} values={values} set={set} />
      {shown === COSTS && <Key />}
      {!isFile && (
        <CostmapOver
          store={store}
          map="terrain"
          label="Costmap over the terrain"
          title="Unsafe patches are the lethal cells of the static layer; the group Costmap shows it, Path plans on it."
        />
      )}
      <h3>Patches</h3>
      <ParameterRows rows={patches} values={values} set={set} />
      <h3>Ground</h3>
      <ParameterRows rows={ground} values={values} set={set} />
      <Button
        kind="quiet"
        onClick={() => {
          terrain.isEnded.value = true;
          store.send({ type: "terrain", value: false });
        }}
      >
        End the assessment
      </Button>
    </div>
  );
}

/** The meaning of the colours of the costs. */
function Key() {
  return (
    <ul class="terrain-key" aria-label="Colours of the patches">
      <li>
        <i class="safe" /> safe, score 0 … 1
      </li>
      <li>
        <i class="unsafe" /> not safe
      </li>
      <li>
        <i class="unknown" /> too few points
      </li>
    </ul>
  );
}

function Begin({ store }: { readonly store: Store }) {
  if (!store.part("terrain").isEnded.value) return <p class="quiet">Waiting for the first points of the 3D sensor …</p>;
  return (
    <Button
      kind="primary"
      onClick={() => {
        store.part("terrain").isEnded.value = false;
      }}
    >
      Assess the terrain
    </Button>
  );
}

interface NumbersProps {
  readonly message: TerrainMessage;
  readonly isFile: boolean;
  readonly rows: readonly Parameter[];
}

const many = (n: number): string => n.toLocaleString("en");

/** The same sentences at all times, because changing ones would move the rows below under the pointer. */
function Numbers({ message, isFile, rows }: NumbersProps) {
  const { points, ground, unsure, left_out, kappa, total_error, truth, safe, unsafe, unknown, before, problem } =
    message;
  if (problem !== null) return <p role="alert">{problem}</p>;
  const names = before?.changed.map((name) => rows.find((row) => row.name === name)?.label ?? name).join(", ");
  return (
    <div role="status" class="terrain-numbers">
      <p>
        <b>{many(safe)}</b> patches are safe, <b>{many(unsafe)}</b> are not, {many(unknown)} have too few points.
      </p>
      <p class="terrain-before">
        {before
          ? `Before the change of “${names}”: ${many(before.safe)} safe, ${many(before.unsafe)} not, ${many(before.unknown)} with too few points.`
          : "Change a parameter to compare these numbers with those after it."}
      </p>
      <p class="quiet">
        {many(ground)} of {many(points)} points are classified as ground
        {left_out > 0 && `; the planes are fitted to ${many(ground - left_out)} of them`}. {many(unsure)} points may
        well be wrong: choose “unsure” over the map to see where they are.
        {kappa !== null &&
          total_error !== null &&
          ` Against ${truth ?? "the truth"}: Cohen’s κ ${written(kappa, 1)} %, ${total_error.toFixed(1)} % of the points wrong.`}
        {isFile && truth === null && " How good is that? Give a file of the true ground points in the tab Compare."}
      </p>
    </div>
  );
}
