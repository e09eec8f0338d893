import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import type { Store } from "../../store/store";

/** The group of a dock that explains a cell. */
const WHY = "why";

/** The open group of a dock, initially `first`. The explanation of a cell replaces another group until it is closed. */
export function useOpenGroup(store: Store | null, first: string): Signal<string> {
  const open = useSignal(first);
  const before = useRef(first);
  const stores = useSignal(store);
  stores.value = store;
  useSignalEffect(() => {
    const explained = stores.value?.explainedPoint;
    if (!explained) return;
    const isExplained = explained.value !== null;
    const now = open.peek();
    if (isExplained && now !== WHY) {
      before.current = now;
      open.value = WHY;
    } else if (!isExplained && now === WHY) {
      open.value = before.current;
    }
  });
  return open;
}
