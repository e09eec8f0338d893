/** The second map of a simulation's readings, in the picture of the first: its names, and the view mode. */

import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Choice } from "../../ui/Choice";
import type { Compared } from "../../wire/protocol";
import { readable } from "../parameters/parameters";
import { Comparison, type ViewMode } from "./comparison";
import { Legend } from "./Legend";

/** The comparison of a store's two maps. */
export function useComparison(store: Store | null): Comparison | null {
  const comparison = useMemo(() => store && new Comparison(store), [store]);
  useEffect(() => {
    const stop = comparison?.start();
    // A simulation only explains the cells of its own map.
    if (store) store.mapAt = null;
    return stop;
  }, [comparison]);
  return comparison;
}

/** Labels of the second map, A, and of the map, B. */
export function secondMapNames(compared: Compared): { readonly a: string; readonly b: string } {
  if (!compared.with_faults) return { a: "correct", b: "as set" };
  return compared.values.clamp === true
    ? { a: "with the clamp", b: "without" }
    : { a: "without the clamp", b: "with it" };
}

/** The differences of the correct map from the map, with the labels of the parameter panel. */
function differenceText(store: Store, compared: Compared): string {
  const table = store.hello.value?.parameters.table ?? [];
  const parts = Object.entries(compared.values).map(([name, value]) => {
    const row = table.find((row) => row.name === name);
    const text = typeof value === "boolean" ? (value ? "on" : "off") : readable(String(value));
    return `${row?.label ?? readable(name)} ${text}${row?.unit ? ` ${row.unit}` : ""}`;
  });
  return ["true poses", "all returns", ...parts].join(", ");
}

const MODES = [
  { value: "swipe", label: "Swipe" },
  { value: "blink", label: "Blink" },
  { value: "difference", label: "Difference" },
] satisfies { value: ViewMode; label: string }[];

/** A description of the second map, and the view mode; nothing if there is only one map. */
export function SecondMapChoice({ store, comparison }: { readonly store: Store; readonly comparison: Comparison }) {
  const compared = store.compared.value;
  if (!compared) return null;
  const mode = comparison.mode.value;
  return (
    <div class="second-map">
      <p>
        {compared.with_faults
          ? "Of both maps in the belief only the clamp differs."
          : `The correct map, A, is of the same readings: ${differenceText(store, compared)}.`}
      </p>
      <Choice
        label="Both maps"
        options={MODES}
        value={mode}
        onChange={(chosen) => {
          comparison.mode.value = chosen;
        }}
      />
      {mode === "difference" && <Legend comparison={comparison} />}
    </div>
  );
}
