import type { Store } from "../../store/store";
import { SwitchChip } from "../../ui/dock/SwitchChip";
import { costmapOf } from "./state";

interface CostmapOverProps {
  readonly store: Store;
  /** The map of the static layer while it is switched on. */
  readonly map: string;
  readonly label: string;
  readonly title: string;
}

/** Whether the costmap uses another map than the belief. */
export function CostmapOver({ store, map, label, title }: CostmapOverProps) {
  const state = costmapOf(store);
  const isOn = state.costmap.value?.is_on === true && state.values.values.value.map === map;
  return (
    <SwitchChip
      label={label}
      title={title}
      checked={isOn}
      onChange={(wanted) => {
        if (wanted) state.isEnded.value = false;
        store.setPart("costmap", { map: wanted ? map : "belief" });
      }}
    />
  );
}
