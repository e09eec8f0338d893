import { type Signal, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { classroom } from "../../store/classroom";
import { followLab, showLab } from "../../tools/classroom/lab";
import type { Live } from "./session";

/** Take part in a class with the lab; returns whether the page follows the lecturer. */
export function useClass(session: Live | null, group: Signal<string>): boolean {
  const live = useSignal(session);
  live.value = session;
  useSignalEffect(() => {
    const room = classroom.value;
    const now = live.value;
    if (!room || !now) return;
    if (!room.isFollowed) return showLab(room, now.store, now.id, group);
    if (room.isFollowing.value) return followLab(room, now.store, group);
    return;
  });
  return useComputed(() => classroom.value?.isFollowing.value ?? false).value;
}
