/** What the tools lay and paint over the robot's map, the undermost first: the one list of them. */

import type { Layer } from "../render/map/renderer";
import type { Brush } from "../render/picture/brush";
import type { Store } from "../store/store";
import { costsOver, paintNavigation, watchNavigation } from "./costmap/paint";
import { paintScanPair } from "./heal/paint";
import { paintGivenPose, paintLocalization } from "./localization/paint";
import { map3dOver, watchMap3d } from "./map3d/over";
import { paintMeasuring, watchMeasuring } from "./measure/paint";
import { paintPatch, watchPatch } from "./terrain/overlay";
import { paintWhy } from "./why/paint";

interface Overlay {
  /** The grids over the map. */
  readonly layers?: (store: Store) => readonly Layer[];
  /** Paint over them. */
  readonly paint?: (store: Store, brush: Brush) => void;
  /** Read every signal that both depend on. */
  readonly watch: (store: Store) => void;
}

export const OVERLAYS: readonly Overlay[] = [
  { watch: (store) => void store.part("localization").message.value, paint: paintLocalization },
  { watch: watchNavigation, layers: costsOver, paint: paintNavigation },
  { watch: watchMap3d, layers: map3dOver },
  { watch: (store) => void store.givenPose.value, paint: paintGivenPose },
  { watch: (store) => void store.scanPair.value, paint: paintScanPair },
  { watch: (store) => void [store.explainedCell.value, store.selectedContribution.value], paint: paintWhy },
  { watch: watchPatch, paint: paintPatch },
  { watch: watchMeasuring, paint: paintMeasuring },
];
