import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import type { Store } from "../store/store";

/** The map's version before its first tiles arrive. */
const EMPTY_MAP = 1;

/** Whether a store has received a map and the robot's pose. */
export const hasPicture = (store: Store): boolean => store.isReady.value && store.mapVersion.value > EMPTY_MAP;

/**
 * The store that the pictures of a page show: `first`, which sends nothing, until the `live` one has a picture. If the
 * user has teleported the robot meanwhile, the live one does so then. Without `first` always the live one.
 */
export function shownStore(live: ReadonlySignal<Store | null>, first: Store | null): ReadonlySignal<Store | null> {
  if (!first) return live;
  const isOver = signal(false);
  const shown = computed(() => (isOver.value || (live.value && hasPicture(live.value)) ? live.value : first));
  const stop = effect(() => {
    const store = shown.value;
    if (!store || store === first) return;
    queueMicrotask(() => {
      stop();
      isOver.value = true; // a later live store replaces this one, not the first picture
      const teleported = first.teleported.peek();
      if (teleported) store.teleport(teleported.point);
    });
  });
  return shown;
}
