/** The effect of a click in a 3D view of the lab while there is a 3D map: query a voxel, or place the robot. */

import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import type { Value } from "../../wire/protocol";
import { ParameterRows } from "../parameters/ParameterRows";
import { useMap3dRows } from "./Sensor3d";

export function ClickChoice({ store }: { readonly store: Store }) {
  const rows = useMap3dRows(store, "click_3d");
  const set = useMemo(() => (name: string, value: Value) => store.setPart("map3d", { [name]: value }), [store]);
  if (store.part("map3d").message.value?.is_on !== true) return null;
  return <ParameterRows rows={rows} values={store.part("map3d").values.values} set={set} />;
}
