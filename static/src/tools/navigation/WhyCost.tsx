/** Why a cell has its cost: what each layer says of it. */

import { useEffect } from "preact/hooks";
import { nameOfCost } from "../../grid/costs";
import type { Store } from "../../store/store";

/** Names of the layers on the page. */
export const LAYER_NAMES: Readonly<Record<string, string>> = {
  static_layer: "Static",
  obstacle_layer: "Obstacle",
  dynamic_layer: "Dynamic",
  keepout_filter: "Keepout",
  inflation_layer: "Inflation",
};
const REPEAT_MS = 500;

export function WhyCost({ store }: { readonly store: Store }) {
  const { asked, cost, costmap } = store.navigation;
  const at = asked.value;
  const isOn = costmap.value?.is_on === true;
  useEffect(() => {
    if (!at || !isOn) return;
    const ask = (): void => store.send({ type: "cost", x: at[0], y: at[1] });
    ask();
    const timer = setInterval(ask, REPEAT_MS);
    return () => clearInterval(timer);
  }, [store, at, isOn]);
  const answer = cost.value;
  if (!at || !answer) return null;
  const last = answer.layers.at(-1);
  return (
    <section class="navigation-why" aria-label="Why this cost" aria-live="polite">
      <h2>
        ({answer.x.toFixed(2)}, {answer.y.toFixed(2)}): {nameOfCost(last?.master ?? 255)}
      </h2>
      <ol>
        {answer.layers.map(({ layer, cost: own, master, sentence }) => (
          <li key={layer}>
            <b>{LAYER_NAMES[layer] ?? layer}</b>
            <span class="navigation-cost">{nameOfCost(own)}</span>
            <span class="navigation-cost">→ {nameOfCost(master)}</span>
            <p>{sentence}</p>
          </li>
        ))}
      </ol>
    </section>
  );
}
