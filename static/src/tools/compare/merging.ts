/** Whether two maps can be merged, by the rules of `merged` in mapper/grid/merge.py. */

import type { Values } from "../../wire/protocol";

/** Models whose maps are not sums of log-odds: they store counts or two certainties for each cell. */
const NOT_ADDITIVE: readonly unknown[] = ["hit_counting", "moravec_elfes"];

/** Why the maps with the settings of A and of B cannot be merged; null if they can. */
export function whyNoMerge(a: Values, b: Values): string | null {
  if (NOT_ADDITIVE.includes(a.model) || NOT_ADDITIVE.includes(b.model))
    return "Maps of hit counting and of Moravec and Elfes are not sums of log-odds and cannot be added.";
  return a.log_odds_prior === b.log_odds_prior ? null : "A and B have different priors and cannot be added.";
}
