import { useSignal } from "@preact/signals";
import { useEffect, useId } from "preact/hooks";
import { NumberField } from "../../../ui/NumberField";
import { Disclosure } from "../../../ui/Panel";
import type { LogInfo, Parameter, Values } from "../../../wire/protocol";
import { SensorProgress } from "./SensorProgress";
import type { Cut, SensorState } from "./useSensor";
import "./sensor.css";

const DEGREES = 180 / Math.PI;

const factor = (row: Parameter): number => (row.unit === "rad" ? DEGREES : 1);

export const shownUnit = (row: Parameter): string => (row.unit === "rad" ? "°" : row.unit);

/** The bounds in the displayed unit, rounded inwards so that an entered value is within the server's bounds. */
export function shownBounds(row: Parameter): readonly [number, number] {
  const inwards = (value: number, up: boolean): number => (up ? Math.ceil : Math.floor)(value * 1e3) / 1e3;
  return [inwards(row.low * factor(row) - 1e-9, true), inwards(row.high * factor(row) + 1e-9, false)];
}

/** Step of the arrow keys in the displayed unit. */
const shownStep = (row: Parameter): number => (row.unit === "pixels" ? 1 : 0.01);

export const shownValue = (row: Parameter, value: number): number => Number((value * factor(row)).toFixed(4));

/** A displayed value in the server's unit and within its bounds; NaN for NaN. */
export const statedValue = (row: Parameter, shown: number): number =>
  Math.min(Math.max(shown / factor(row), row.low), row.high);

/** The error of the values in combination; null if they define a cut. */
export function faultOf(cut: Readonly<Record<string, number>>): string | null {
  const { min_height, max_height, angle_min, angle_max } = cut;
  if (Object.values(cut).some((value) => Number.isNaN(value))) return "Each field needs a number.";
  if (min_height !== undefined && max_height !== undefined && min_height >= max_height)
    return "The lowest height must be below the greatest.";
  if (angle_min !== undefined && angle_max !== undefined && angle_min >= angle_max)
    return "The first bearing must be below the last.";
  return null;
}

interface CutFormProps {
  readonly log: LogInfo;
  readonly sensor: SensorState;
}

/** The cut of the map's scans from point clouds or depth images; nothing for the scans of a lidar. */
export function CutForm({ log, sensor }: CutFormProps) {
  if (!log.cut) return null;
  return (
    <Disclosure
      title={
        log.cut.table.some((row) => row.name === "min_height") ? "Scans cut from clouds" : "Scans cut from depth images"
      }
      note={log.topic}
      open
    >
      <Fields
        key={JSON.stringify(log.cut.values)}
        table={log.cut.table}
        values={log.cut.values}
        sensor={sensor}
        topic={log.topic}
      />
    </Disclosure>
  );
}

interface FieldsProps {
  readonly table: readonly Parameter[];
  readonly values: Values;
  readonly sensor: SensorState;
  readonly topic: string;
}

function Fields({ table, values, sensor, topic }: FieldsProps) {
  const start = (): Cut =>
    Object.fromEntries(table.map((row) => [row.name, shownValue(row, Number(values[row.name]))]));
  const typed = useSignal(start()); // as displayed
  useEffect(() => {
    typed.value = start();
  }, [values]);
  const stated: Cut = Object.fromEntries(
    table.map((row) => [row.name, statedValue(row, typed.value[row.name] ?? Number.NaN)]),
  );
  const fault = faultOf(stated);
  const isChanged = table.some((row) => Math.abs((stated[row.name] ?? 0) - Number(values[row.name])) > 1e-9);
  return (
    <form
      class="cut-form"
      onSubmit={(event) => {
        event.preventDefault();
        void sensor.use(topic, stated);
      }}
    >
      <p class="quiet">The recording is read again to cut its scans; the map stays at the same time.</p>
      {table.map((row) => (
        <Field
          key={row.name}
          row={row}
          value={typed.value[row.name] ?? Number.NaN}
          onType={(value) => {
            typed.value = { ...typed.value, [row.name]: value };
          }}
        />
      ))}
      <div class="actions">
        <button
          type="submit"
          class="button primary"
          disabled={fault !== null || !isChanged || sensor.reading.value !== null}
        >
          Cut the scans again
        </button>
      </div>
      <p role="status">{fault}</p>
      <SensorProgress sensor={sensor} />
    </form>
  );
}

interface FieldProps {
  readonly row: Parameter;
  readonly value: number;
  readonly onType: (value: number) => void;
}

function Field({ row, value, onType }: FieldProps) {
  const id = useId();
  const [low, high] = shownBounds(row);
  return (
    <div class="cut-field" title={row.sentence}>
      <label for={id}>{row.label}</label>
      <NumberField
        id={id}
        class="field-text number"
        low={low}
        high={high}
        step={shownStep(row)}
        value={value}
        onType={onType}
        onChange={onType}
      />
      <span class="quiet">{shownUnit(row)}</span>
    </div>
  );
}
