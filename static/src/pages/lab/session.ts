import { computed, effect } from "@preact/signals";
import type { Store } from "../../store/store";
import { LIKELIHOOD_FIELD } from "../../tools/localization/model";
import { filterOf } from "../../tools/localization/state";
import { withLayout } from "../../ui/stage/useLayout";
import { ask, RequestError } from "../../wire/ask";
import { CancelledError, createWorld, RefusedError } from "../worldSession";
import { currentLinkState, fragmentOf, type LinkState, linkFromAddress, type VisibleState } from "./link";

/** The session that the lab shows, and a notice about how it was opened. */
export interface Opened {
  readonly id: string;
  readonly notice: string | null;
  /** The state in the address, if the session was made from it. */
  readonly shown: LinkState | null;
}

/** Delay between a change and the update of the address. */
const SETTLE_MS = 400;
/** The address follows a playing world at this interval of simulated time, seconds. */
const FOLLOW_S = 10;

const address = (id: string): string => `/lab.html${withLayout(new URLSearchParams({ session: id }))}`;

/**
 * Open the session that the address names. If it has ended, open a copy of the world described in the address, paused
 * if `isPaused`, otherwise a new world. Throws if none can be opened; the address still describes the world.
 */
export async function openSession(isPaused = false): Promise<Opened> {
  const requested = new URLSearchParams(location.search).get("session");
  const shown = await linkFromAddress();
  let notice: string | null = null;
  if (requested) {
    try {
      const { kind } = await ask("GET /api/sessions/{session_id}", { session_id: requested });
      if (kind === "log") location.replace(`/logs.html?session=${encodeURIComponent(requested)}`);
      return { id: requested, notice: null, shown: null };
    } catch (error) {
      if (!(error instanceof RequestError && error.status === 404)) throw error;
    }
    notice = shown
      ? "That session had ended because it had no viewers. Its world was restored."
      : "That session has ended because it had no viewers. This is a new world.";
  }
  if (shown) {
    try {
      const id = await createWorld(shown.story, isPaused);
      history.replaceState(null, "", address(id) + location.hash);
      return { id, notice, shown };
    } catch (error) {
      if (error instanceof CancelledError) notice = "The replay of the link was cancelled. This is a new world.";
      else if (error instanceof RefusedError)
        notice = `The world of the link cannot be made: ${error.message} This is a new world.`;
      else throw error;
    }
  } else if (location.hash.startsWith("#s=")) {
    notice = "The link is incomplete or damaged. This is a new world.";
  }
  const id = await createWorld();
  history.replaceState(null, "", address(id));
  return { id, notice, shown: null };
}

/** Restore the state of a link. What needs the server is restored when the connection is ready. */
export function restore(store: Store, shown: VisibleState): void {
  store.activeFaults.value = shown.wrong;
  if (shown.view) store.setView(shown.view);
  store.pinned.value = shown.pinned;
  if (shown.why) {
    store.explain(shown.why.at);
    store.selectedUpdate.value = shown.why.touch;
  }
  const { right, filter, map3d } = shown;
  if (!right && !filter && !map3d) return;
  const stop = effect(() => {
    if (!store.isReady.value) return;
    if (right) store.send({ type: "compare", values: right });
    if (filter) {
      filterOf(store).begin(filter.values, filter.map);
      if (filter.field) store.underlay.value = LIKELIHOOD_FIELD;
    }
    if (map3d) store.send({ type: "map3d", values: map3d });
    queueMicrotask(() => stop());
  });
}

/** Keep the address up to date with the state of the page; the returned function stops it. */
export function keepAddress(id: string, store: Store): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let stopped = false;
  let newest = 0;
  const moment = computed(() => {
    const frame = store.frame.value;
    return frame?.playing ? `play ${Math.floor(frame.t / FOLLOW_S)}` : `stand ${frame?.index}`;
  });
  const write = async (): Promise<void> => {
    const version = ++newest;
    try {
      const fragment = await fragmentOf(await currentLinkState(id, store));
      if (!stopped && version === newest) history.replaceState(null, "", address(id) + fragment);
    } catch {
      // If the server does not answer, the page reports it elsewhere, and the next change updates the address.
    }
  };
  const stop = effect(() => {
    void [store.history.version.value, moment.value];
    void store.viewHeld.value;
    if (store.viewHeld.value) void store.view.value;
    void [store.pinned.value, store.explainedPoint.value, store.selectedUpdate.value, store.compared.value];
    void [
      store.part("localization").message.value?.is_on,
      filterOf(store).values.value,
      filterOf(store).map.value,
      store.underlay.value,
    ];
    void [store.part("map3d").message.value?.is_on, store.part("map3d").values.values.value];
    if (!store.isReady.value) return;
    clearTimeout(timer);
    timer = setTimeout(() => void write(), SETTLE_MS);
  });
  return () => {
    stopped = true;
    clearTimeout(timer);
    stop();
  };
}

/** The address of this live session. */
export const liveAddress = (id: string): string => new URL(address(id), location.href).href;

/** The address that opens a copy of the current state in a new session at any time. */
export async function snapshotAddress(id: string, store: Store): Promise<string> {
  return new URL(
    `/lab.html${withLayout(new URLSearchParams())}${await fragmentOf(await currentLinkState(id, store))}`,
    location.href,
  ).href;
}
