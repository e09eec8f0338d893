/** The session that a follower's page is connected to: the lecturer's, or the follower's own copy. */

import { computed, effect } from "@preact/signals";
import { classroom } from "../store/classroom";
import { type Connection, connect, connectToClass } from "../store/connect";
import type { SessionPage } from "../tools/classroom/session";

/** The connection to a session, with its id. */
export interface Live extends Connection {
  readonly id: string;
}

/** Used instead of a session's key when the class has ended or the page is about to be replaced. */
const LAST = "last";

/**
 * Call `connected` with the session to show whenever it changes; null while there is none. When the class is over, or
 * while the page that the lecturer has opened is loading, this page keeps its content without a connection.
 */
export function watchClassSession(page: SessionPage, connected: (session: Live | null) => void): void {
  const wanted = computed(() => {
    const room = classroom.value;
    if (room?.isOver.value) return LAST;
    if (!room) return null;
    if (room.own.value !== null) return `own ${room.own.value}`;
    const shown = room.shown.value;
    if (shown && shown.view.page !== page && shown.view.page !== "other") return LAST;
    return shown && shown.view.page === page && shown.stage > 0 ? `stage ${shown.stage}` : null;
  });
  let now: Live | null = null;
  const show = (next: Live | null): void => {
    now = next;
    connected(next);
  };
  effect(() => {
    const room = classroom.peek();
    const key = wanted.value;
    if (key === LAST && now) {
      now.stop();
      return;
    }
    if (!room || key === null || key === LAST) {
      show(null);
      return;
    }
    const own = room.own.peek();
    const drives = (): boolean => room.drives.peek();
    show(own === null ? { ...connectToClass(room.code, drives), id: key } : { ...connect(own), id: own });
  });
}
