import { computed } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { ParameterPanel } from "../../tools/parameters/ParameterPanel";
import { Profile } from "../../tools/profile/Profile";
import { profileReading } from "../../tools/profile/reading";
import { CutForm } from "./sensor/CutForm";
import type { SensorState } from "./sensor/useSensor";

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
          beamName={pointed ? "the beam towards the pointer" : "the beam straight ahead"}
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
