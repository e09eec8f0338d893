/** Whether two maps can be added; as `merged` of mapper/grid/merge.py refuses them. */

import type { Values } from "../../wire/protocol";

/** Models whose maps are no sums of log-odds: they count, or keep two certainties a cell. */
const NO_SUMS: readonly unknown[] = ["hit_counting", "moravec_elfes"];

/** Why a map with the settings of A and one with those of B cannot be added; null where they can. */
export function whyNoMerge(a: Values, b: Values): string | null {
  if (NO_SUMS.includes(a.model) || NO_SUMS.includes(b.model))
    return "Only maps that are sums of log-odds can be added; one of these counts.";
  return a.log_odds_prior === b.log_odds_prior ? null : "A and B began from different priors, and cannot be added.";
}
