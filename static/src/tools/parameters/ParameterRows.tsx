import type { ReadonlySignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Choice } from "../../ui/Choice";
import type { Range } from "../../ui/numbers";
import { Slider, type Tone } from "../../ui/Slider";
import { Toggle } from "../../ui/Toggle";
import type { Parameter, Value, Values } from "../../wire/protocol";
import { boundsOf, isEnabled, isShown, readable } from "./parameters";

/** The rows of a part's parameters that `isShown` accepts; `type` is that of the part's command. */
export function useTable(store: Store, type: string, isShown: (row: Parameter) => boolean): readonly Parameter[] {
  const table = store.hello.value?.tables[type];
  return useMemo(() => table?.filter(isShown) ?? [], [table]);
}

const TONES: Record<string, Tone> = {
  log_odds_hit: "hit",
  p_occ: "hit",
  window: "hit",
  log_odds_max: "hit",
  log_odds_miss: "miss",
  p_free: "miss",
  log_odds_min: "miss",
  range_max: "beam",
  log_odds_prior: "prior",
};

interface RowsProps {
  readonly rows: readonly Parameter[];
  readonly values: ReadonlySignal<Values>;
  readonly set: (name: string, value: Value) => void;
}

/** A control for each row of a table; rows that do not apply to the current model are left out. */
export function ParameterRows({ rows, values, set }: RowsProps) {
  const now = values.value;
  return (
    <>
      {rows
        .filter((row) => isShown(row, now))
        .map((row) => (
          <Control key={row.name} row={row} values={now} set={set} />
        ))}
    </>
  );
}

interface ControlProps {
  readonly row: Parameter;
  readonly values: Values;
  readonly set: (name: string, value: Value) => void;
}

/** A control is rendered only when its own values change, so that dragging one does not render the others. */
function Control({ row, values, set }: ControlProps) {
  const value = values[row.name] ?? row.initial;
  const disabled = !isEnabled(row, values);
  const { low, high, step } = boundsOf(row, values);
  return useMemo(
    () => controlOf(row, value, { low, high, step }, disabled, (next) => set(row.name, next)),
    [row, value, low, high, step, disabled, set],
  );
}

function controlOf(row: Parameter, value: Value, range: Range, disabled: boolean, change: (next: Value) => void) {
  if (row.kind === "flag") {
    return (
      <Toggle
        label={row.label}
        sentence={row.sentence}
        checked={value === true}
        disabled={disabled}
        onChange={change}
      />
    );
  }
  if (row.kind === "choice") {
    const options = row.choices.map((choice) => ({ value: choice, label: readable(choice) }));
    return (
      <Choice
        label={row.label}
        sentence={row.sentence}
        options={options}
        value={String(value)}
        disabled={disabled}
        onChange={change}
      />
    );
  }
  return (
    <Slider
      label={row.label}
      sentence={row.sentence}
      unit={row.unit}
      tone={TONES[row.name] ?? "accent"}
      value={Number(value)}
      initial={Number(row.initial)}
      disabled={disabled}
      {...range}
      onInput={change}
    />
  );
}
