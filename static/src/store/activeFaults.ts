/** Which faults are on: all that a page has to know of them until somebody unfolds the switches. */

import type { Values } from "../wire/protocol";

/** What holds while faults are on: which, in the order in which they were switched on, and what was there before. */
export interface ActiveFaults {
  readonly on: readonly string[];
  readonly before: Values;
}

export const NO_ACTIVE_FAULTS: ActiveFaults = { on: [], before: {} };
