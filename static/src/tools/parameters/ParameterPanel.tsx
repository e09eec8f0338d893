import type { ReadonlySignal } from "@preact/signals";
import { Disclosure } from "../../ui/Panel";
import type { Parameter, Value, Values } from "../../wire/protocol";
import { ParameterRows } from "./ParameterRows";
import { changedOf, grouped, readable } from "./parameters";

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
export function ParameterPanel({ table, values, set, open = [] }: PanelProps) {
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
