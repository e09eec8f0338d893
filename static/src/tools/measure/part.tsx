import type { PagePart } from "../part";
import { paintMeasuring, watchMeasuring } from "./paint";

export const PART: PagePart = {
  overlay: { watch: watchMeasuring, paint: paintMeasuring },
};
