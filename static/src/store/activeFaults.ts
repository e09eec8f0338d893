/** Which faults are on: all that a page needs before the panel of faults is loaded. */

import type { Values } from "../wire/protocol";

/** The faults that are on, in the order in which they were switched on, and the parameters before. */
export interface ActiveFaults {
  readonly on: readonly string[];
  readonly before: Values;
}

export const NO_ACTIVE_FAULTS: ActiveFaults = { on: [], before: {} };
