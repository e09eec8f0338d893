/** The surface of the lab's 3D scans: one beam in both maps, the parameters of signed distances, and its size. */

import { useMemo } from "preact/hooks";
import { SurfaceProfile } from "../../lessons/tsdf/SurfaceProfile";
import type { Store } from "../../store/store";
import type { Value } from "../../wire/protocol";
import { ParameterRows } from "../parameters/ParameterRows";
import { useMap3dRows } from "./Sensor3d";
import "./surfacePanel.css";

export function SurfacePanel({ store }: { readonly store: Store }) {
  const rows = useMap3dRows(store, "tsdf_3d");
  const set = useMemo(() => (name: string, value: Value) => store.setPart("map3d", { [name]: value }), [store]);
  const { values } = store.part("map3d").values;
  return (
    <section class="surface-panel" aria-label="The same beam, two beliefs">
      <h3>The same beam, two beliefs</h3>
      <p class="map3d-note">
        20 readings of a wall, as occupied cells and as signed distances. Drag the truncation or the maximum weight: the
        surface is made again.
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
