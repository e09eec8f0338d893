/** State that a reader can change on the way through the lecture, and the way back to the lecture's own state. */

import { computed, type Signal, signal } from "@preact/signals";

const left: { readonly now: Signal<unknown>; readonly first: unknown }[] = [];
const count = signal(0);

/** A signal whose first value is the lecture's: {@link backToPath} restores it. */
export function onPath<T>(first: T): Signal<T> {
  const now = signal(first);
  left.push({ now: now as Signal<unknown>, first });
  count.value = left.length;
  return now;
}

/** Whether the reader has changed anything. */
export const isOffPath = computed(() => count.value > 0 && left.some(({ now, first }) => now.value !== first));

export function backToPath(): void {
  for (const { now, first } of left) now.value = first;
}
