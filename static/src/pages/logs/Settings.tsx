import { computed, type ReadonlySignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { ParameterRows } from "../../tools/parameters/ParameterRows";
import { changedOf, grouped, readable } from "../../tools/parameters/parameters";
import { Profile } from "../../tools/profile/Profile";
import { profileReading } from "../../tools/profile/reading";
import { Disclosure } from "../../ui/Panel";
import type { Parameter, Value, Values } from "../../wire/protocol";
import { CutForm } from "./sensor/CutForm";
import type { SensorState } from "./sensor/useSensor";

const TITLES: Record<string, string> = {
  model: "Sensor model",
  update: "Update",
  map: "Map",
  mount: "Sensor mount",
  sensor: "Sensor",
};

interface PanelProps {
  readonly table: readonly Parameter[];
  readonly values: ReadonlySignal<Values>;
  readonly set: (name: string, value: Value) => void;
  /** Groups that are open at first, in addition to the first group. */
  readonly open?: readonly string[];
}

/** Every parameter of a table as a control, by group; rows that do not apply to the current model are hidden. */
function ParameterPanel({ table, values, set, open = [] }: PanelProps) {
  const now = values.value;
  return (
    <div class="parameters">
      {grouped(table, now).map((group, n) => (
        <Disclosure
          key={group.name}
          title={TITLES[group.name] ?? readable(group.name)}
          note={changedNote(group.rows, now)}
          open={n === 0 || open.includes(group.name)}
        >
          <ParameterRows rows={group.rows} values={values} set={set} />
        </Disclosure>
      ))}
    </div>
  );
}

function changedNote(rows: readonly Parameter[], values: Values): string | null {
  const changed = changedOf(rows, values);
  return changed === 0 ? null : `${changed} changed`;
}

interface SettingsProps {
  readonly store: Store;
  /** Changes how scans are cut out of clouds; null for a guest. */
  readonly sensor: SensorState | null;
}

/** The inverse sensor model as a curve, and every parameter of the map. */
export function Settings({ store, sensor }: SettingsProps) {
  const reading = useMemo(() => computed(() => profileReading(store)), [store]);
  const set = useMemo(() => (name: string, value: number) => store.setParameter(name, value), [store]);
  const hello = store.hello.value;
  const pointed = store.probe.value !== null;
  return (
    <>
      {hello?.log && sensor && <CutForm log={hello.log} sensor={sensor} />}
      <section aria-label="Inverse sensor model">
        <Profile
          parameters={store.mapping.values}
          setParameter={set}
          reading={reading}
          where={pointed ? "towards the pointer" : "straight ahead"}
        />
      </section>
      {hello && (
        <ParameterPanel
          table={hello.parameters.table}
          values={store.mapping.values}
          set={(name, value) => store.setParameter(name, value)}
        />
      )}
    </>
  );
}
