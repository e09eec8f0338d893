/** Work that may be refused: it is shown while it goes on, and afterwards why it failed. */

import { batch, type ReadonlySignal, type Signal, useSignal } from "@preact/signals";
import { toast } from "../Toast";

const whyOf = (error: unknown): string => (error as Error).message;

/** Do `work`, and say in a toast why it fails if it does. */
export async function toastFailure(work: () => Promise<unknown>): Promise<void> {
  try {
    await work();
  } catch (error) {
    toast(whyOf(error), "error");
  }
}

interface Attempts {
  readonly isBusy: ReadonlySignal<boolean>;
  /** Why the newest one failed; null while it goes on, and where it did not fail. */
  readonly failure: Signal<string | null>;
  readonly attempt: (work: () => Promise<unknown>) => Promise<void>;
}

/** The attempts of a component, one at a time. */
export function useAttempts(): Attempts {
  const isBusy = useSignal(false);
  const failure = useSignal<string | null>(null);
  const attempt = async (work: () => Promise<unknown>): Promise<void> => {
    isBusy.value = true;
    failure.value = null;
    try {
      await work();
    } catch (error) {
      failure.value = whyOf(error);
    }
    isBusy.value = false;
  };
  return { isBusy, failure, attempt };
}

/** Send a request, and show its answer or `failure`, unless the returned function has ended it: the work of an effect. */
export function showAnswer<T>(
  send: (ending: AbortSignal) => Promise<T>,
  failure: Signal<string | null>,
  show: (answer: T) => void,
): () => void {
  const abort = new AbortController();
  send(abort.signal).then(
    (answer) =>
      batch(() => {
        failure.value = null;
        show(answer);
      }),
    (error: Error) => {
      if (!abort.signal.aborted) failure.value = whyOf(error);
    },
  );
  return () => abort.abort();
}
