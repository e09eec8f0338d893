import { CostCurve as Curve } from "../../render/chart/CostCurve";
import type { Store } from "../../store/store";
import type { Range } from "../../ui/numbers";
import { costmapOf } from "./state";

/** The curve of the session's costs. */
export function CostCurve({ store }: { readonly store: Store }) {
  const state = costmapOf(store);
  const costmap = state.costmap.value;
  const values = state.values.values.value;
  const table = store.hello.value?.tables.costmap;
  const row = (name: string): Range => table?.find((one) => one.name === name) ?? { low: 0, high: 1, step: 0.1 };
  if (!costmap) return null;
  return (
    <Curve
      inscribed={costmap.inscribed_radius}
      circumscribed={costmap.circumscribed_radius}
      inflation={{
        inflation_radius: Number(values.inflation_radius),
        cost_scaling_factor: Number(values.cost_scaling_factor),
      }}
      ranges={{ inflation_radius: row("inflation_radius"), cost_scaling_factor: row("cost_scaling_factor") }}
      onChange={(name, value) => store.setPart("costmap", { [name]: value })}
    />
  );
}
