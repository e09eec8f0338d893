import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { Button } from "../../ui/Button";
import { NumberField } from "../../ui/NumberField";
import type { FleetOptions as Options } from "../../wire/http";

const NAMES = [
  { name: "topic", label: "Sensor", none: "the one with most scans" },
  { name: "tf", label: "Topic of transforms", none: "by its namespace" },
  { name: "trajectory", label: "Poses", none: "each log’s first" },
] as const;

const METRES = { low: -2, high: 2, step: 0.01, per: 1 };
const NUMBERS = [
  { name: "mount_x", label: "Mount forward (m)", ...METRES },
  { name: "mount_y", label: "Mount left (m)", ...METRES },
  { name: "mount_yaw", label: "Mount yaw (°)", low: -180, high: 180, step: 1, per: Math.PI / 180 },
  { name: "time_offset", label: "Time offset (s)", low: -2, high: 2, step: 0.01, per: 1 },
] as const;

/** Options for reading and mapping all logs, as of `gridbloom fleet`. */
export function FleetOptions({
  isBusy,
  onMap,
}: {
  readonly isBusy: boolean;
  readonly onMap: (options: Options) => void;
}) {
  const id = useId();
  const options = useSignal<Options>({});
  const set = (change: Options): void => {
    options.value = { ...options.peek(), ...change };
  };
  return (
    <details class="fleet-options">
      <summary>Options</summary>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          onMap(options.peek());
        }}
      >
        {NAMES.map(({ name, label, none }) => (
          <div key={name}>
            <label for={id + name}>{label}</label>
            <input
              id={id + name}
              class="field-text"
              placeholder={none}
              maxLength={255}
              onInput={(event) => set({ [name]: event.currentTarget.value.trim() || null })}
            />
          </div>
        ))}
        {NUMBERS.map(({ name, label, low, high, step, per }) => (
          <div key={name}>
            <label for={id + name}>{label}</label>
            <NumberField
              id={id + name}
              class="field-text"
              low={low}
              high={high}
              step={step}
              value={(options.value[name] ?? 0) / per}
              onChange={(value) => set({ [name]: value * per })}
            />
          </div>
        ))}
        <label class="fleet-check">
          <input type="checkbox" onChange={(event) => set({ mount_upside_down: event.currentTarget.checked })} />
          Mount turned over
        </label>
        <p class="fleet-shared">A log of the server’s folder has one result, which all visitors see.</p>
        <Button submits disabled={isBusy}>
          Map all with these options
        </Button>
      </form>
    </details>
  );
}
