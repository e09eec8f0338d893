/** Which faults are on: all that a page has to know of them until somebody unfolds the switches. */

import type { Values } from "../../protocol";

/** What holds while faults are on: which, in the order in which they were switched on, and what was there before. */
export interface Wrong {
  readonly on: readonly string[];
  readonly before: Values;
}

export const NOTHING_WRONG: Wrong = { on: [], before: {} };
