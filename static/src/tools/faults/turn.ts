/** Switches faults of a session on and off. */

import { computed, type ReadonlySignal } from "@preact/signals";
import type { ActiveFaults } from "../../store/sessionSignals";
import type { Store } from "../../store/store";
import type { Values } from "../../wire/protocol";
import { type Fault, stillActive, switchFault } from "./model";

const NO_FAULTS: Values = {};

/** The active faults: those that were switched on and not ended by a slider or by undo. */
export const activeNow = (store: Store): ReadonlySignal<ActiveFaults> =>
  computed(() => stillActive(store.activeFaults.value, store.mapping.values.value, store.faults.value ?? NO_FAULTS));

/** Switch a fault on or off, together with others of the robot; return the faults that are then active. */
export function turnFault(store: Store, fault: Fault, wanted: boolean, also: Values = {}): ActiveFaults {
  // The state of the robot may be older than the previous switch, so it is not used here.
  const known = stillActive(store.activeFaults.peek(), store.mapping.values.peek(), null);
  const next = switchFault(known, fault, wanted, store.mapping.values.peek());
  store.activeFaults.value = next.wrong;
  store.setTogether(`fault ${fault.name}`, next.values, { ...next.robot, ...also });
  return next.wrong;
}
