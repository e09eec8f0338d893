/** The page that a follower's browser shows, and that of a lecturer who shows a page that cannot be followed. */

import { effect, signal, useSignalEffect } from "@preact/signals";
import { classroom, followedCode } from "../../store/classroom";
import type { ClassView } from "../../wire/protocol";

type Page = ClassView["page"];

const OTHER: ClassView = { page: "other", hash: "", blank: false };

/** The page that a follower's browser is loading, because the lecturer has opened it; null for none. */
export const loadingPage = signal<Page | null>(null);

/** Keep a follower on the page that the lecturer shows. `page` is this page, null if lecturers never show it. */
export function followPages(page: Page | null): void {
  if (followedCode === null) return;
  // Each navigation cancels the previous one. What the lecturer does meanwhile on the same page must not restart it.
  let last = page;
  effect(() => {
    const room = classroom.value;
    const target = room?.shown.value?.view.page;
    if (!room?.isFollowing.value || !target || target === last) return;
    last = target;
    loadingPage.value = target;
    location.replace(`/class/${room.code}/${target}.html`);
  });
}

function sendOther(): void {
  const room = classroom.value;
  if (room && !room.isFollowed) room.send({ type: "show", view: OTHER });
}

/** Report to the followers that this page cannot be followed. */
export function showOther(): void {
  effect(sendOther);
}

/** The same, for a part of a page that cannot be followed while the rest can. */
export function ShowsOther() {
  useSignalEffect(sendOther);
  return null;
}
