/** The comparison in the address: who opens it sees both maps as they were, in this session or in a new one. */

import { computed, effect } from "@preact/signals";
import type { Marked } from "../../../render/map/difference";
import type { Store } from "../../../store/store";
import { BLINK_S, type Comparison, LOOKS, type Look } from "../../../tools/compare/comparison";
import type { Parameter, Value, Values } from "../../../wire/protocol";
import { compareWith, type Other } from "./sides";

/** What the address carries after `#compare=`, as JSON. */
export interface Linked {
  readonly look: Look;
  /** Where the divider is, in hundredths. */
  readonly at?: number;
  readonly every?: number;
  readonly mark?: Marked;
  /** The other side; of its parameters only those that are not as at first. */
  readonly a: Other;
  /** The side that the sliders move, likewise. */
  readonly b: { readonly values: Values; readonly trajectory: string; readonly index?: number };
}

const MARK = "#compare=";

/** What the address says; null for nothing, or what cannot be read. */
export function linkFromAddress(fragment: string): Linked | null {
  if (!fragment.startsWith(MARK)) return null;
  try {
    const linked = JSON.parse(decodeURIComponent(fragment.slice(MARK.length))) as Partial<Linked>;
    if (!LOOKS.includes(linked.look as Look) || typeof linked.a !== "object" || typeof linked.b?.values !== "object")
      return null;
    return linked as Linked;
  } catch {
    return null;
  }
}

export const fragmentOf = (linked: Linked): string => MARK + encodeURIComponent(JSON.stringify(linked));

/** The values that are not those of the table. */
export function changed(table: readonly Parameter[], values: Values): Values {
  const rows = table.filter((row) => values[row.name] !== undefined && values[row.name] !== row.initial);
  return Object.fromEntries(rows.map((row) => [row.name, values[row.name] as Value]));
}

/** All values, those that are left out as the table has them. */
export const whole = (table: readonly Parameter[], values: Values): Values => ({
  ...Object.fromEntries(table.map((row) => [row.name, row.initial])),
  ...values,
});

/** How the maps are looked at now. */
function linkedOf(store: Store, comparison: Comparison): Linked | null {
  const compared = store.compared.value;
  const table = store.hello.value?.parameters.table;
  const trajectory = store.trajectory.value?.name;
  if (!compared || !table || trajectory === undefined) return null;
  const look = comparison.look.value;
  const mark = comparison.marked.value;
  const keeps = Object.keys(compared.values).length > 0;
  const frame = store.frame.value;
  return {
    look,
    ...(look === "swipe" ? { at: Math.round(100 * comparison.divider.value) } : {}),
    ...(look === "blink" ? { every: comparison.blinkS.value } : {}),
    ...(mark ? { mark } : {}),
    a: {
      ...(keeps ? { values: changed(table, compared.values) } : {}),
      trajectory: compared.trajectory ?? null,
      ...(compared.log ? { log: compared.log, topic: compared.topic ?? null } : {}),
    },
    b: {
      values: changed(table, store.mapping.values.value),
      trajectory,
      ...(frame && !frame.playing ? { index: frame.index } : {}),
    },
  };
}

/** How long after a change the address follows. */
const SETTLE_MS = 400;

/** Let the address follow what is compared; the result stops it. */
export function keepAddress(store: Store, comparison: Comparison): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const fragment = computed(() => {
    const linked = linkedOf(store, comparison);
    return linked ? fragmentOf(linked) : "";
  });
  const stop = effect(() => {
    const now = fragment.value;
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (location.hash === now || (now === "" && !location.hash.startsWith(MARK))) return;
      history.replaceState(null, "", location.pathname + location.search + now);
    }, SETTLE_MS);
  });
  return () => {
    clearTimeout(timer);
    stop();
  };
}

/** Look as the address says. A session that compares already goes on; another is brought to where the link was made. */
export async function restore(
  session: string,
  store: Store,
  comparison: Comparison,
  linked: Linked,
): Promise<string | null> {
  comparison.look.value = linked.look;
  if (linked.at !== undefined) comparison.divider.value = Math.min(1, Math.max(0, linked.at / 100));
  const every = BLINK_S.find((seconds) => seconds === linked.every);
  if (every !== undefined) comparison.blinkS.value = every;
  comparison.marked.value = linked.mark ?? null;
  const table = store.hello.peek()?.parameters.table;
  if (store.compared.peek() || !table) return null;
  const { a, b } = linked;
  store.setTogether("link", whole(table, b.values));
  if (store.trajectory.peek()?.name !== b.trajectory) store.send({ type: "trajectory", name: b.trajectory });
  if (b.index !== undefined) {
    store.send({ type: "pause" });
    store.send({ type: "seek", index: b.index });
  }
  return compareWith(session, { ...a, ...(a.values ? { values: whole(table, a.values) } : {}) });
}
