/** Why a cell has its cost: the contribution of each layer. */

import { effect, untracked, useComputed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { nameOfCost } from "../../grid/costs";
import type { Store } from "../../store/store";
import { written } from "../../ui/numbers";
import { pathOf } from "../path/state";
import { costmapOf } from "./state";

/** Names of the layers on the page. */
export const LAYER_NAMES: Readonly<Record<string, string>> = {
  static_layer: "Static",
  obstacle_layer: "Obstacle",
  dynamic_layer: "Dynamic",
  terrain_layer: "Terrain",
  keepout_filter: "Keepout",
  inflation_layer: "Inflation",
};
/** Least time between two questions. */
const LEAST_MS = 500;

export function WhyCost({ store }: { readonly store: Store }) {
  const { asked, cost, costmap } = costmapOf(store);
  const { path } = pathOf(store);
  const scans = useComputed(() => store.frame.value?.index);
  const at = asked.value;
  const isOn = costmap.value?.is_on === true;
  useEffect(() => {
    if (!at || !isOn) return;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isStale = false;
    const ask = (): void => {
      isStale = false;
      store.send({ type: "cost", x: at[0], y: at[1] });
      timer = setTimeout(() => {
        timer = undefined;
        if (isStale) ask();
      }, LEAST_MS);
    };
    const stop = effect(() => {
      // A cost depends on the parameters, on the scans, and on the costs around it, whose changes cause replanning.
      void [costmap.value, path.value, scans.value];
      if (timer === undefined) untracked(ask);
      else isStale = true;
    });
    return () => {
      stop();
      clearTimeout(timer);
    };
  }, [store, at, isOn, scans]);
  const answer = cost.value;
  if (!at || !answer) return null;
  const last = answer.layers.at(-1);
  return (
    <section class="navigation-why" aria-label="Why this cost" aria-live="polite">
      <h2>
        ({written(answer.x, 2)}, {written(answer.y, 2)}): {nameOfCost(last?.master ?? 255)}
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
      {answer.speed !== null && <p>{answer.speed}</p>}
    </section>
  );
}
