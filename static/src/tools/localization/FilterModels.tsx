/** What a particle filter takes the sensor and the wheels to be like: figures that one grabs, and the numbers. */

import { computed, type ReadonlySignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { Disclosure } from "../../ui/Panel";
import type { Parameter, Values } from "../../wire/protocol";
import { ParameterRows } from "../parameters/ParameterRows";
import { MotionFan } from "./MotionFan";
import { SensorCurve } from "./SensorCurve";

interface ModelsProps {
  readonly table: readonly Parameter[];
  /** Those that differ from the first values. */
  readonly values: ReadonlySignal<Values>;
  /** The sensor's longest range, m. */
  readonly range_max: number;
  readonly set: (values: Values) => void;
}

const of = (table: readonly Parameter[], group: string): readonly Parameter[] =>
  table.filter((row) => row.group === group);

export function FilterModels({ table, values, range_max, set }: ModelsProps) {
  const all = useMemo(
    () =>
      computed(
        (): Values => ({
          ...Object.fromEntries(table.map((row) => [row.name, row.initial])),
          ...values.value,
        }),
      ),
    [table, values],
  );
  const setOne = useMemo(() => (name: string, value: Values[string]) => set({ [name]: value }), [set]);
  const sensor = of(table, "sensor");
  const model = sensor.filter((row) => row.name === "laser_model_type");
  const numbers = sensor.filter((row) => row.name !== "laser_model_type");
  const now = all.value;
  if (table.length === 0) return null;
  return (
    <>
      <Disclosure title="Sensor model">
        <ParameterRows rows={model} values={all} set={setOne} />
        <SensorCurve values={now} rows={sensor} range_max={range_max} set={set} />
        <ParameterRows rows={numbers} values={all} set={setOne} />
      </Disclosure>
      <Disclosure title="Motion model">
        <MotionFan values={now} />
        <ParameterRows rows={of(table, "motion")} values={all} set={setOne} />
      </Disclosure>
    </>
  );
}
