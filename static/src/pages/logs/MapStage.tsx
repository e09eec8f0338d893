import type { ReadonlySignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import type { Picture } from "../../render/picture/Picture";
import type { Store } from "../../store/store";
import type { Comparison } from "../../tools/compare/comparison";
import { CompareReadout } from "../../tools/compare/Readout";
import { MapTools, Measuring } from "../../tools/measure/MapTools";
import { BeliefView } from "../../tools/picture/BeliefView";
import { ComputingMap } from "../../tools/picture/ComputingMap";
import { Readout } from "../../tools/readout/Readout";
import { BothMaps } from "./compare/useComparison";
import { Transport } from "./Transport";

interface MapStageProps {
  readonly store: Store;
  readonly comparison: Comparison;
  /** An error of the connection; null for none. */
  readonly trouble: ReadonlySignal<string | null>;
  /** Whether all its controls are disabled. */
  readonly isInert?: boolean;
  /** Called with the picture of the map. */
  readonly onPicture: (picture: Picture) => void;
}

/** The map of a log with its playback, the values of the cell under the pointer, and the tools that measure. */
export function MapStage({ store, comparison, trouble, isInert = false, onPicture }: MapStageProps) {
  const stage = useRef<HTMLDivElement>(null);
  return (
    <div class="viewer-stage" inert={isInert} ref={stage}>
      <div class="viewer-map">
        <BeliefView store={store} comparison={comparison} onPicture={onPicture} />
        <BothMaps store={store} comparison={comparison} />
        {isInert ? <Measuring store={store} /> : <MapTools store={store} stage={stage} />}
        {trouble.value && (
          <p class="viewer-over" role="status">
            {trouble.value}
          </p>
        )}
        <ComputingMap store={store} />
      </div>
      <Transport store={store} />
      <div class="viewer-readout">
        {comparison.isOn.value ? (
          <CompareReadout store={store} summedOver={comparison.summedOver.value} />
        ) : (
          <Readout store={store} />
        )}
      </div>
    </div>
  );
}
