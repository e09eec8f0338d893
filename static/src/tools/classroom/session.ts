/** A session in a class: what the lecturer's page shows of it is sent, and the followers' pages show the same. */

import { effect, type Signal } from "@preact/signals";
import { framed, type SharedView } from "../../render/view";
import type { Classroom } from "../../store/classroom";
import type { Store } from "../../store/store";
import type { ClassView } from "../../wire/protocol";
import type { Audience } from "./pageInSlide";

/** Least time between two messages about what is shown, and about the explanation of a cell. */
const SHOW_EVERY_MS = 60;
const EXPLAIN_EVERY_MS = 500;

/** Call `task` at most once in `ms`: immediately, and with the newest value again when the time is over. */
export function throttled<T>(task: (value: T) => void, ms: number): (value: T) => void {
  let last = Number.NEGATIVE_INFINITY;
  let timer: ReturnType<typeof setTimeout> | undefined;
  return (value) => {
    clearTimeout(timer);
    const run = (): void => {
      last = performance.now();
      task(value);
    };
    const wait = last + ms - performance.now();
    if (wait <= 0) run();
    else timer = setTimeout(run, wait);
  };
}

const sizeOf = (store: Store): { readonly width: number; readonly height: number } | null => {
  const sizes = [...store.pictures.values()].filter((size) => size.width > 0 && size.height > 0);
  return sizes[0] ?? null;
};

/** A page that shows a session. */
export type SessionPage = "lab" | "logs";

/** Send what the lecturer's page shows of its session, until the returned function is called. */
export function showSession(
  audience: Audience,
  store: Store,
  session: string,
  page: SessionPage,
  group: Signal<string>,
): () => void {
  let isShown = true; // throttled calls may come later
  const send: Audience["send"] = (command) => {
    if (isShown) audience.send(command);
  };
  const show = throttled((view: ClassView) => send({ type: "show", view, session }), SHOW_EVERY_MS);
  const explain = throttled<typeof store.why.value>((why) => send({ type: "explain", why }), EXPLAIN_EVERY_MS);
  const stops = [
    effect(() => {
      const view = store.view.value;
      const size = sizeOf(store);
      show({
        page,
        hash: "",
        blank: false,
        look: store.viewHeld.value && view && size ? { ...view, ...size } : null,
        pointer: store.pointer.value,
        pinned: store.pinned.value,
        explained: store.explainedPoint.value,
        update: store.selectedUpdate.value,
        group: group.value,
      });
    }),
    effect(() => explain(store.explainedPoint.value ? store.why.value : null)),
  ];
  return () => {
    isShown = false;
    for (const stop of stops) stop();
  };
}

/**
 * Make a follower's page show what the lecturer's does, until the returned function is called. `groups` are the ids of
 * the groups of controls on the follower's page, null for all.
 */
export function followSession(
  room: Classroom,
  store: Store,
  group: Signal<string>,
  groups: readonly string[] | null = null,
): () => void {
  const look = (shared: SharedView | null): void => {
    const size = sizeOf(store);
    if (shared && size) store.setView(framed(shared, size));
    else {
      store.viewHeld.value = false;
      store.fitView();
    }
  };
  let lookBefore = "";
  const stops = [
    effect(() => {
      const view = room.shown.value?.view;
      if (!view || !store.isReady.value) return;
      store.pointer.value = view.pointer ?? null;
      store.pinned.value = view.pinned ?? null;
      store.explainedPoint.value = view.explained ?? null;
      store.selectedUpdate.value = view.update ?? null;
      if (view.group && (groups?.includes(view.group) ?? true)) group.value = view.group;
      const now = JSON.stringify(view.look ?? null);
      if (now !== lookBefore) {
        lookBefore = now;
        look(view.look ?? null);
      }
    }),
    effect(() => {
      store.why.value = room.shown.value?.view.explained ? room.explained.value : null;
    }),
  ];
  return () => {
    for (const stop of stops) stop();
  };
}
