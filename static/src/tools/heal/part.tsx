import type { PagePart } from "../part";
import { paintScanPair } from "./paint";

export const PART: PagePart = {
  overlay: { watch: (store) => void store.scanPair.value, paint: paintScanPair },
};
