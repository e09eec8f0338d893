/** The comparison in the address, so that it can be restored in this session or in a new one. */

import { computed, effect } from "@preact/signals";
import type { Marked } from "../../../render/map/difference";
import type { Store } from "../../../store/store";
import { BLINK_S, type Comparison, VIEW_MODES, type ViewMode } from "../../../tools/compare/comparison";
import type { ComparedMap } from "../../../wire/http";
import type { Parameter, Value, Values } from "../../../wire/protocol";
import { compareWith } from "./sides";

/** The JSON value after `#compare=` in the address. */
export interface Linked {
  readonly look: ViewMode;
  /** Position of the divider, percent of the width. */
  readonly at?: number;
  readonly every?: number;
  readonly mark?: Marked;
  /** The other map; only the parameters that differ from the defaults. */
  readonly a: ComparedMap;
  /** The map that the sliders change, likewise. */
  readonly b: { readonly values: Values; readonly trajectory: string; readonly index?: number };
}

const MARK = "#compare=";

/** The comparison in a fragment; null if there is none or it is invalid. */
export function linkFromAddress(fragment: string): Linked | null {
  if (!fragment.startsWith(MARK)) return null;
  try {
    const linked = JSON.parse(decodeURIComponent(fragment.slice(MARK.length))) as Partial<Linked>;
    if (
      !VIEW_MODES.includes(linked.look as ViewMode) ||
      typeof linked.a !== "object" ||
      typeof linked.b?.values !== "object"
    )
      return null;
    return linked as Linked;
  } catch {
    return null;
  }
}

export const fragmentOf = (linked: Linked): string => MARK + encodeURIComponent(JSON.stringify(linked));

/** The values that differ from those of the table. */
export function changed(table: readonly Parameter[], values: Values): Values {
  const rows = table.filter((row) => values[row.name] !== undefined && values[row.name] !== row.initial);
  return Object.fromEntries(rows.map((row) => [row.name, values[row.name] as Value]));
}

/** All values; missing ones have their defaults. */
export const whole = (table: readonly Parameter[], values: Values): Values => ({
  ...Object.fromEntries(table.map((row) => [row.name, row.initial])),
  ...values,
});

/** The current comparison as a fragment; "" for none. */
export function comparisonFragment(store: Store, comparison: Comparison): string {
  const linked = linkedOf(store, comparison);
  return linked ? fragmentOf(linked) : "";
}

function linkedOf(store: Store, comparison: Comparison): Linked | null {
  const compared = store.compared.value;
  const table = store.hello.value?.parameters.table;
  const trajectory = store.trajectory.value?.name;
  if (!compared || !table || trajectory === undefined) return null;
  const mode = comparison.mode.value;
  const mark = comparison.marked.value;
  const keeps = Object.keys(compared.values).length > 0;
  const frame = store.frame.value;
  return {
    look: mode,
    ...(mode === "swipe" ? { at: Math.round(100 * comparison.divider.value) } : {}),
    ...(mode === "blink" ? { every: comparison.blinkS.value } : {}),
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

/** Delay between a change and the update of the address. */
const SETTLE_MS = 400;

/** Keep the address up to date with the comparison; the returned function stops it. */
export function keepAddress(store: Store, comparison: Comparison): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const fragment = computed(() => comparisonFragment(store, comparison));
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

/** Restore the comparison of a link. A session that already compares keeps its maps; otherwise both are set up. */
export async function restore(
  session: string,
  store: Store,
  comparison: Comparison,
  linked: Linked,
): Promise<string | null> {
  comparison.mode.value = linked.look;
  if (linked.at !== undefined) comparison.divider.value = Math.min(1, Math.max(0, linked.at / 100));
  const every = BLINK_S.find((seconds) => seconds === linked.every);
  if (every !== undefined) comparison.blinkS.value = every;
  comparison.marked.value = linked.mark ?? null;
  const table = store.hello.peek()?.parameters.table;
  if (store.compared.peek() || !table) return null;
  const { a, b } = linked;
  store.setTogether("link", whole(table, b.values));
  if (store.trajectory.peek()?.name !== b.trajectory) store.send({ type: "trajectory", name: b.trajectory });
  if (b.index !== undefined) store.goTo(b.index);
  return compareWith(session, { ...a, ...(a.values ? { values: whole(table, a.values) } : {}) });
}
