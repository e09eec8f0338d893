/** The parameters of the map and of the sensor, by group. */

import type { Store } from "../../../store/store";
import { Sensor3d } from "../../../tools/map3d/Sensor3d";
import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { Button } from "../../../ui/Button";

interface SettingsProps {
  readonly store: Store;
}

function Rows({ store, groups }: SettingsProps & { readonly groups: readonly string[] }) {
  const rows = store.hello.value?.parameters.table.filter((row) => groups.includes(row.group)) ?? [];
  return (
    <ParameterRows rows={rows} values={store.mapping.values} set={(name, value) => store.setParameter(name, value)} />
  );
}

function Defaults({ store }: SettingsProps) {
  return (
    <Button kind="quiet" icon="restart" onClick={() => store.reset()}>
      Reset to defaults
    </Button>
  );
}

export function ModelSettings({ store }: SettingsProps) {
  return (
    <div class="lab-settings">
      <Rows store={store} groups={["model"]} />
      <Defaults store={store} />
    </div>
  );
}

export function MapSettings({ store }: SettingsProps) {
  return (
    <div class="lab-settings">
      <Rows store={store} groups={["update", "map"]} />
      <Defaults store={store} />
    </div>
  );
}

export function SensorSettings({ store }: SettingsProps) {
  const table = store.hello.value?.sensor?.table ?? [];
  return (
    <div class="lab-settings lab-sensor">
      <h3>The sensor in the world</h3>
      <ParameterRows rows={table} values={store.sensor.values} set={(name, value) => store.setSensor(name, value)} />
      <Sensor3d store={store} />
      <h3>Its mount, as the map assumes it</h3>
      <Rows store={store} groups={["mount"]} />
      <Defaults store={store} />
    </div>
  );
}
