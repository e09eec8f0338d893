import type { PagePart } from "../part";
import { paintWhy } from "./paint";

export const PART: PagePart = {
  overlay: { watch: (store) => void [store.explainedCell.value, store.selectedContribution.value], paint: paintWhy },
};
