import { type Signal, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { classroom } from "../store/classroom";
import { slidesAround } from "../tools/classroom/pageInSlide";
import { followSession, type SessionPage, showSession } from "../tools/classroom/session";
import type { Live } from "./classSession";

interface Options {
  readonly page: SessionPage;
  /** The id of the open group of controls. */
  readonly group: Signal<string>;
  /** The groups of a follower's page; all if omitted. */
  readonly groups?: readonly string[];
}

/**
 * Take part in a class with a session. Returns whether the page follows the lecturer, or shows the last state of a
 * class that is over.
 */
export function useClass(session: Live | null, { page, group, groups }: Options): boolean {
  const live = useSignal(session);
  live.value = session;
  useSignalEffect(() => {
    const room = classroom.value;
    const now = live.value;
    if (!now) return;
    const audience = room?.isFollowed ? null : (room ?? slidesAround);
    if (audience) return showSession(audience, now.store, now.id, page, group);
    if (room?.isFollowing.value) return followSession(room, now.store, group, groups);
    return;
  });
  return useComputed(() => {
    const room = classroom.value;
    return (room?.isFollowed && (room.isFollowing.value || room.isOver.value)) ?? false;
  }).value;
}
