/** The user's state of the path: the goal, and the place to which it is dragged. */

import { type Signal, signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { PathMessage, Point } from "../../wire/protocol";

class PathState {
  /** The newest message; null before the first. */
  readonly path: Signal<PathMessage | null>;
  /** The place to which the goal is dragged; null while it is not. */
  readonly goalAt = signal<Point | null>(null);
  readonly #store: Store;

  constructor(store: Store) {
    this.#store = store;
    this.path = store.part("path").message;
  }

  /** Set the goal of the path, immediately, so that the path is planned while the pointer moves. Null removes it. */
  setGoal(point: Point | null): void {
    this.#store.send(point ? { type: "goal", x: point[0], y: point[1] } : { type: "goal" });
  }

  /** Drag the goal to a point; null when it is released. */
  dragGoal(point: Point | null): void {
    this.goalAt.value = point;
    if (point) this.setGoal(point);
  }
}

export const pathOf = (store: Store): PathState => store.of(PathState);
