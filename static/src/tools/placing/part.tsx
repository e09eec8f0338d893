import { paintGivenPose } from "../localization/paint";
import type { PagePart } from "../part";

export const PART: PagePart = {
  overlay: { watch: (store) => void store.givenPose.value, paint: paintGivenPose },
};
