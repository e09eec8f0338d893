/** The visible part of a map, as a link holds it. */

import type { RefObject } from "preact";
import type { Picture } from "../../../render/picture/Picture";
import { framed, type SharedView } from "../../../render/view";
import type { Store } from "../../../store/store";
import type { DoctorAnswer } from "../../../wire/http";
import type { Shown } from "./links";

/** A visitor with a shared link: the initial view, and a callback for the end of the session. */
export interface GuestOfLink {
  readonly view: SharedView | null;
  readonly shown?: Shown | null;
  /** What the sender had been told about the log; null where it had not been examined. */
  readonly examination?: DoctorAnswer | null;
  readonly onEnded: () => void;
}

/** The visitor's view, if they moved it: otherwise the link shows everything on any screen. */
export function sharedViewOf(store: Store, picture: RefObject<Picture | null>): SharedView | null {
  const view = store.view.peek();
  const size = picture.current?.size;
  return store.viewHeld.peek() && view && size ? { ...view, width: size.width, height: size.height } : null;
}

/** Show the shared part of the map as soon as the picture has a size. */
export function applySharedView(store: Store, picture: RefObject<Picture | null>, view: SharedView | null): () => void {
  let waiting = 0;
  const wait = (): void => {
    const size = picture.current?.size;
    if (view && size && size.width > 0) store.setView(framed(view, size));
    else if (view) waiting = requestAnimationFrame(wait);
  };
  wait();
  return () => cancelAnimationFrame(waiting);
}
