import { effect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { CompareOverlay } from "../../../tools/compare/CompareOverlay";
import { Comparison } from "../../../tools/compare/comparison";
import { isWriting } from "../../../ui/browser/isTyping";
import { toast } from "../../../ui/Toast";
import { keepAddress, linkFromAddress, restore } from "./link";
import { names } from "./sides";

/** Both maps of a comparison in one picture, as described by the address or by the fragment of a link. */
export function useComparison(session: string, store: Store, fragment: string | null = null): Comparison {
  const comparison = useMemo(() => new Comparison(store), [store]);
  useEffect(() => {
    const stops = [comparison.start()];
    const linked = linkFromAddress(location.hash) ?? linkFromAddress(fragment ?? "");
    const follow = (): void => void stops.push(keepAddress(store, comparison));
    if (!linked) follow();
    else {
      // When the session has reported what it compares.
      let isRestored = false;
      const stop = effect(() => {
        if (isRestored || !store.isReady.value || !store.trajectory.value) return;
        isRestored = true;
        setTimeout(async () => {
          const failure = await restore(session, store, comparison, linked);
          if (failure !== null) toast(failure, "error");
          follow();
        });
      });
      stops.push(stop);
    }
    const onKey = (event: KeyboardEvent): void => {
      if (event.key !== "b" || event.ctrlKey || event.metaKey || event.altKey) return;
      const isBlinking = comparison.isOn.peek() && comparison.mode.peek() === "blink";
      if (isBlinking && !isWriting(event.target)) comparison.turn();
    };
    addEventListener("keydown", onKey);
    stops.push(() => removeEventListener("keydown", onKey));
    return () => {
      for (const stop of stops) stop();
    };
  }, [comparison]);
  return comparison;
}

export function BothMaps({ store, comparison }: { store: Store; comparison: Comparison }) {
  const compared = store.compared.value;
  if (!compared) return null;
  const { a, b } = names(compared, store.trajectory.value?.name ?? "", store.hello.value?.title ?? "");
  const pair = comparison.pair.value;
  const refused = store.part("comparison").message.value?.refused ?? (pair && !pair.lattice ? APART : null);
  return <CompareOverlay comparison={comparison} names={{ a, b }} refused={refused} />;
}

const APART = "The cells of the two maps do not coincide.";
