/** Faults: one switch for each, what to look for, and the correct map for comparison. */

import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { SwitchChip } from "../../ui/dock/SwitchChip";
import type { Value, Values } from "../../wire/protocol";
import type { Comparison } from "../compare/comparison";
import { SecondMapChoice } from "../compare/SecondMap";
import { readable } from "../parameters/parameters";
import { availableFaults, correctValues, type Fault } from "./model";
import { activeNow, turnFault } from "./turn";
import "./faults.css";

interface FaultsProps {
  readonly store: Store;
  readonly comparison: Comparison;
}

export function Faults({ store, comparison }: FaultsProps) {
  const hello = store.hello.value;
  const wrong = useMemo(() => activeNow(store), [store]);
  if (!hello) return null;
  const beside = store.compared.value !== null && !store.compared.value.with_faults;
  const turn = (fault: Fault, wanted: boolean): void => {
    const next = turnFault(store, fault, wanted);
    if (beside) store.send({ type: "compare", values: correctValues(next) });
  };
  const showCorrectMap = (wanted: boolean): void =>
    store.send({ type: "compare", values: wanted ? correctValues(wrong.peek()) : null });
  const faults = availableFaults(hello.parameters.table);
  const active = faults.filter((fault) => wrong.value.on.includes(fault.name));
  return (
    <div class="faults stack">
      <div class="actions">
        {faults.map((fault) => {
          const on = wrong.value.on.includes(fault.name);
          return (
            <SwitchChip
              key={fault.name}
              isFault
              label={fault.label}
              title={fault.look}
              checked={on}
              onChange={(wanted) => turn(fault, wanted)}
            />
          );
        })}
        <span class="faults-correct">
          <SwitchChip label="Show the correct map" checked={beside} onChange={showCorrectMap} />
        </span>
      </div>
      <div class="faults-note" role="status">
        {active.length === 0 && !beside && (
          <p>
            Switch a fault on to see its effect on the map. Switching it off restores the settings. In the{" "}
            <a href="/puzzles.html">puzzles</a> faults are hidden.
          </p>
        )}
        {active.map((fault) => (
          <p key={fault.name}>
            <b>Look for:</b> {fault.look}{" "}
            <span class="faults-sets">{sentence(fault, wrong.value.before, hello.parameters.table)}</span>
          </p>
        ))}
      </div>
      {beside && <SecondMapChoice store={store} comparison={comparison} />}
    </div>
  );
}

type Labels = readonly { readonly name: string; readonly label: string; readonly unit: string }[];

/** The parameters that a fault has changed, with their current and previous values. */
function sentence(fault: Fault, before: Values, table: Labels): string {
  const row = (name: string): Labels[number] | undefined => table.find((row) => row.name === name);
  const text = (name: string, value: Value | undefined): string => {
    if (typeof value === "boolean") return value ? "on" : "off";
    const unit = row(name)?.unit;
    return `${readable(String(value))}${unit ? ` ${unit}` : ""}`;
  };
  const changes = Object.entries(fault.sets).map(
    ([name, value]) => `${row(name)?.label ?? name} is ${text(name, value)}, was ${text(name, before[name])}`,
  );
  return changes.length > 0 ? `(${changes.join("; ")}.)` : "";
}
