import { effect } from "@preact/signals";
import type { Store } from "../../store/store";
import { CancelledError, createWorld } from "../worldSession";
import { currentLinkState, fragmentOf, type LinkState, linkFromAddress, type VisibleState } from "./link";

/** Which session the lab shows, and what a person should know of how it came about. */
export interface Opened {
  readonly id: string;
  readonly notice: string | null;
  /** What the address carried, where the session was made of it. */
  readonly shown: LinkState | null;
}

/** How long after a change the address follows. */
const SETTLE_MS = 800;

const address = (id: string): string => `/lab.html?session=${encodeURIComponent(id)}`;

/**
 * The session that the address names while it lives; else the world that the address tells of, made again; else a new
 * one. Throws where none can be had.
 */
export async function openSession(): Promise<Opened> {
  const wanted = new URLSearchParams(location.search).get("session");
  const shown = await linkFromAddress();
  let notice: string | null = null;
  if (wanted) {
    const answer = await fetch(`/api/sessions/${encodeURIComponent(wanted)}`);
    if (answer.ok) {
      const { kind } = (await answer.json()) as { kind?: string };
      if (kind === "log") location.replace(`/logs.html?session=${encodeURIComponent(wanted)}`);
      return { id: wanted, notice: null, shown: null };
    }
    if (answer.status !== 404) throw new Error(`The server answered ${answer.status}; this page goes on trying.`);
    notice = shown
      ? "That world had ended: sessions close when nobody watches them. Here it is again."
      : "That world has ended: sessions close when nobody watches them. Here is a new one.";
  }
  if (shown) {
    try {
      const id = await createWorld(shown.story);
      history.replaceState(null, "", address(id) + location.hash);
      return { id, notice, shown };
    } catch (error) {
      if (error instanceof TypeError) throw error;
      if (error instanceof CancelledError) notice = "The replay of the link was cancelled. Here is a new world.";
      else notice = `The link tells of a world that cannot be made: ${(error as Error).message} Here is a new one.`;
    }
  } else if (location.hash.startsWith("#s=")) {
    notice = "The link has lost a piece on its way, so here is a new world.";
  }
  const id = await createWorld();
  history.replaceState(null, "", address(id));
  return { id, notice, shown: null };
}

/** Show what the link showed; what the server has to be asked for, when it is there. */
export function restore(store: Store, shown: VisibleState): void {
  store.activeFaults.value = shown.wrong;
  if (shown.view) store.look(shown.view);
  store.pinned.value = shown.pinned;
  if (shown.why) {
    store.ask(shown.why.at);
    store.touched.value = shown.why.touch;
  }
  const { right } = shown;
  if (!right) return;
  const stop = effect(() => {
    if (!store.isReady.value) return;
    store.send({ type: "compare", values: right });
    queueMicrotask(() => stop());
  });
}

/** Let the address follow what a person does; the result stops it. */
export function keepAddress(id: string, store: Store): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let stopped = false;
  const write = async (): Promise<void> => {
    try {
      const fragment = await fragmentOf(await currentLinkState(id, store));
      if (!stopped) history.replaceState(null, "", address(id) + fragment);
    } catch {
      // The server is away: the page says so elsewhere, and the address follows with the next change.
    }
  };
  const stop = effect(() => {
    void store.history.version.value;
    void store.viewHeld.value;
    if (store.viewHeld.value) void store.view.value;
    void [store.pinned.value, store.asked.value, store.touched.value, store.compared.value];
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

/** The address that shows this very session to somebody else, while it lives. */
export const liveAddress = (id: string): string => new URL(address(id), location.href).href;

/** The address that opens what is on show now in a session of its own, whenever. */
export async function snapshotAddress(id: string, store: Store): Promise<string> {
  return new URL(`/lab.html${await fragmentOf(await currentLinkState(id, store))}`, location.href).href;
}
