/** Which session a follower's lab is connected to: the one that the lecturer shows, or a copy of one's own. */

import { computed, effect } from "@preact/signals";
import { classroom } from "../../store/classroom";
import { connect, connectToClass } from "../../store/connect";
import type { Live } from "./session";

/** Call `connected` with the session to show, whenever it is another one; null while there is none. */
export function watchClassSession(connected: (session: Live | null) => void): void {
  const wanted = computed(() => {
    const room = classroom.value;
    if (!room || room.isOver.value) return null;
    if (room.own.value !== null) return `own ${room.own.value}`;
    const shown = room.shown.value;
    return shown && shown.view.page === "lab" && shown.stage > 0 ? `stage ${shown.stage}` : null;
  });
  effect(() => {
    const room = classroom.peek();
    const key = wanted.value;
    if (!room || key === null) {
      connected(null);
      return;
    }
    const own = room.own.peek();
    const drives = (): boolean => room.drives.peek();
    connected(own === null ? { ...connectToClass(room.code, drives), id: key } : { ...connect(own), id: own });
  });
}
