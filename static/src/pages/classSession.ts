/** Which session a follower's page is connected to: the one that the lecturer shows, or a copy of one's own. */

import { computed, effect } from "@preact/signals";
import { classroom } from "../store/classroom";
import { type Connection, connect, connectToClass } from "../store/connect";
import type { SessionPage } from "../tools/classroom/session";

/** The connection to a session, with its id. */
export interface Live extends Connection {
  readonly id: string;
}

/** Call `connected` with the session to show on a page, whenever it is another one; null while there is none. */
export function watchClassSession(page: SessionPage, connected: (session: Live | null) => void): void {
  const wanted = computed(() => {
    const room = classroom.value;
    if (!room || room.isOver.value) return null;
    if (room.own.value !== null) return `own ${room.own.value}`;
    const shown = room.shown.value;
    return shown && shown.view.page === page && shown.stage > 0 ? `stage ${shown.stage}` : null;
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
