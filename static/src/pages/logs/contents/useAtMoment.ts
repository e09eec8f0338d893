import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../../store/store";

/** Minimum interval of requests while the log plays or is sought. */
const EVERY_MS = 250;

type AtMoment<T> =
  | { readonly kind: "none" }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "ready"; readonly value: T };

/**
 * The server's data at the log's present time: requested when the time or the address changes, at most four times per
 * second and one request at a time.
 */
export function useAtMoment<T>(
  store: Store,
  addressAt: (seconds: number) => string,
  fetchAt: (address: string, ending: AbortSignal) => Promise<T>,
): AtMoment<T> {
  const state = useSignal<AtMoment<T>>({ kind: "none" });
  const address = useSignal("");
  const addressOf = useRef(addressAt);
  addressOf.current = addressAt;
  const follow = (): void => {
    const stamp = store.frame.peek()?.stamp;
    if (stamp !== undefined) address.value = addressOf.current(stamp);
  };
  useSignalEffect(() => {
    void store.frame.value;
    follow();
  });
  useEffect(follow);
  useEffect(() => {
    const abort = new AbortController();
    let asked = "";
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async (): Promise<void> => {
      timer = undefined;
      asked = address.peek();
      try {
        const value = await fetchAt(asked, abort.signal);
        if (abort.signal.aborted) return;
        state.value = { kind: "ready", value };
      } catch (error) {
        if (abort.signal.aborted) return;
        state.value = { kind: "failed", why: (error as Error).message };
      }
      isAsking = false;
      if (!abort.signal.aborted) next();
    };
    let isAsking = false;
    const next = (): void => {
      if (isAsking || address.peek() === asked || address.peek() === "") return;
      isAsking = true;
      timer = setTimeout(() => void ask(), asked === "" ? 0 : EVERY_MS);
    };
    const stop = address.subscribe(next);
    return () => {
      stop();
      abort.abort();
      clearTimeout(timer);
    };
  }, []);
  return state.value;
}
