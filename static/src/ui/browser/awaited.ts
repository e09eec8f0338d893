/** Whether the server answers while the page waits for it. */

import { computed, signal } from "@preact/signals";

/** Whether a request waits, and a second one that asks for nothing is not answered meanwhile either. */
export const isStalled = signal(false);

/** How many parts of the page say in their own place that the server does not answer. */
const sayers = signal(0);

/** Count one more or one less of them; an effect that does so does not depend on their number. */
export const countSayers = (change: 1 | -1): void => {
  sayers.value = sayers.peek() + change;
};

/** Whether the page has to say so where it shows its messages. */
export const hasStalled = computed(() => isStalled.value && sayers.value === 0);

/** After this time the server is asked whether it is there, and after the same time again it is said not to answer. */
const PROBE_MS = 1000;
/** A browser has as many connections to a server without HTTP/2; one more request would wait for those before it. */
const MOST_AT_ONCE = 6;

let waiting = 0;
let timer: ReturnType<typeof setInterval> | undefined;
let isAsked = false;

function probe(): void {
  if (isAsked) {
    isStalled.value = true;
    return;
  }
  if (waiting >= MOST_AT_ONCE) return;
  isAsked = true;
  void fetch("/livez", { cache: "no-store" })
    .catch(() => undefined) // the requests that wait are told the same
    .then(() => {
      isAsked = false;
      isStalled.value = false;
    });
}

/** Wait for an answer of the server; meanwhile {@link isStalled} tells whether it answers at all. */
export async function awaited<T>(answer: Promise<T>): Promise<T> {
  waiting++;
  timer ??= setInterval(probe, PROBE_MS);
  try {
    return await answer;
  } finally {
    waiting--;
    if (waiting === 0) {
      clearInterval(timer);
      timer = undefined;
      isStalled.value = false;
    }
  }
}
