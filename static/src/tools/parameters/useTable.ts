import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import type { Parameter } from "../../wire/protocol";

/** The rows of a part's parameters that `isShown` accepts; `type` is that of the part's command. */
export function useTable(store: Store, type: string, isShown: (row: Parameter) => boolean): readonly Parameter[] {
  const table = store.hello.value?.tables[type];
  return useMemo(() => table?.filter(isShown) ?? [], [table]);
}
