import type { Store } from "../../../store/store";
import { selectionOf } from "../../../tools/scene/selection";
import { secondsAt } from "./scanTimes";

/** The times of what is selected in all views, s from the first scan: of the selected beam, or of the scans. */
export function selectedTimes(store: Store): readonly number[] {
  const selection = selectionOf(store).value;
  if (selection?.what === "cell") {
    const beam = store.selectedContribution.value;
    return beam ? [beam.stamp] : [];
  }
  const trajectory = store.trajectory.value;
  return trajectory && selection ? selection.scans.map((scan) => secondsAt(trajectory, scan + 1)) : [];
}
