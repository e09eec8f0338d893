/** The 3D sensor of the simulated robot: its type and its parameters. */

import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Choice } from "../../ui/Choice";
import type { Value } from "../../wire/protocol";
import { ParameterRows, useTable } from "../parameters/ParameterRows";

const NONE = "none";
const KINDS = [
  { value: NONE, label: "None" },
  { value: "spinning_lidar", label: "Spinning lidar" },
  { value: "tilted_lidar", label: "Tilted lidar" },
  { value: "depth_camera", label: "Depth camera" },
];

/** The rows of the 3D map's parameters in a group. */
export const useMap3dRows = (store: Store, group: string) =>
  useTable(store, "map3d", (row) => row.group === group && row.name !== "sensor");

export function Sensor3d({ store }: { readonly store: Store }) {
  const rows = useMap3dRows(store, "sensor_3d");
  const set = useMemo(() => (name: string, value: Value) => store.setPart("map3d", { [name]: value }), [store]);
  const map3d = store.part("map3d");
  const isOn = map3d.message.value?.is_on === true;
  return (
    <>
      <h3>An additional 3D sensor</h3>
      <Choice
        label="3D sensor"
        sentence="Its readings go into the 3D map, in the group of that name."
        options={KINDS}
        value={isOn ? String(map3d.values.values.value.sensor) : NONE}
        onChange={(value) => {
          map3d.isEnded.value = value === NONE;
          if (value === NONE) store.send({ type: "map3d", value: false });
          else store.setPart("map3d", { sensor: value });
        }}
      />
      {isOn && <ParameterRows rows={rows} values={map3d.values.values} set={set} />}
    </>
  );
}
