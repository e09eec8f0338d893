import { useEffect } from "preact/hooks";
import type { Store } from "../../store/store";
import { PLAN, SPEED_LIMITS } from "./paint";

/**
 * Begin the costmap of a session, unless the user has ended it; receive the path and what is laid over the belief, and
 * give the user the tools of the map while a group shows them.
 */
export function useCostmap(store: Store): void {
  const { navigation, layers } = store;
  const isOn = navigation.costmap.value?.is_on === true;
  const isEnded = navigation.isEnded.value;
  const over = navigation.over.value;
  // A given map may have speed limits of its own.
  const isGiven = navigation.values.values.value.map === "given";
  const isLimited = isGiven || navigation.costmap.value?.keepout.some(({ speed }) => speed != null) === true;
  useEffect(() => {
    if (!isOn && !isEnded && navigation.costmap.peek()) store.send({ type: "costmap" });
  }, [store, isOn, isEnded, navigation.costmap.value === null]);
  useEffect(() => (isOn ? layers.subscribe(PLAN) : undefined), [store, isOn]);
  useEffect(() => (isOn && over ? layers.subscribe(over) : undefined), [store, isOn, over]);
  useEffect(() => (isOn && isLimited ? layers.subscribe(SPEED_LIMITS) : undefined), [store, isOn, isLimited]);
  useEffect(() => {
    navigation.over.value ??= "costmap";
    navigation.tool.value = navigation.lastTool.peek();
    return () => {
      navigation.tool.value = null;
    };
  }, [store]);
}
