/** Starting and ending the costmap: by opening a group that shows it, and by buttons. */

import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { PLAN, SPEED_LIMITS } from "./paint";
import { costmapOf } from "./state";

/**
 * Begin the costmap of a session, unless the user has ended it. While a group shows them, subscribe to the path and the
 * layers over the belief, and enable the tools of the map.
 */
export function useCostmap(store: Store): void {
  const { layers } = store;
  const state = costmapOf(store);
  const isOn = state.costmap.value?.is_on === true;
  const isEnded = state.isEnded.value;
  const over = state.over.value;
  // A reference map may have speed limits of its own.
  const isGiven = state.values.values.value.map === "given";
  const isLimited = isGiven || state.costmap.value?.keepout.some(({ speed }) => speed != null) === true;
  useEffect(() => {
    if (!isOn && !isEnded && state.costmap.peek()) store.send({ type: "costmap" });
  }, [store, isOn, isEnded, state.costmap.value === null]);
  useEffect(() => (isOn ? layers.subscribe(PLAN) : undefined), [store, isOn]);
  useEffect(() => (isOn && over ? layers.subscribe(over) : undefined), [store, isOn, over]);
  useEffect(() => (isOn && isLimited ? layers.subscribe(SPEED_LIMITS) : undefined), [store, isOn, isLimited]);
  useEffect(() => {
    state.over.value ??= "costmap";
    state.tool.value = state.lastTool.peek();
    return () => {
      state.tool.value = null;
    };
  }, [store]);
}

/** The rows of the parameters of these names, in this order. */
export function useRows(store: Store, names: readonly string[]) {
  const table = store.hello.value?.tables.costmap;
  return useMemo(() => names.flatMap((name) => table?.filter((row) => row.name === name) ?? []), [table, names]);
}

/** A button that begins the costmap after the user has ended it. */
export function Begin({ store }: { readonly store: Store }) {
  if (!costmapOf(store).isEnded.value) return <p class="navigation-note">Computing the costmap …</p>;
  const begin = (): void => {
    costmapOf(store).isEnded.value = false;
  };
  return (
    <Button kind="primary" onClick={begin}>
      Make the costmap
    </Button>
  );
}

export function End({ store }: { readonly store: Store }) {
  return (
    <Button
      kind="quiet"
      onClick={() => {
        costmapOf(store).isEnded.value = true;
        store.send({ type: "costmap", value: false });
      }}
    >
      End the costmap
    </Button>
  );
}
