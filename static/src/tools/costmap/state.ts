/** The user's state of the costmap: the tool of the map, the stroke being painted, the queried place. */

import { type Signal, signal } from "@preact/signals";
import type { Optimistic } from "../../store/optimistic";
import type { Store } from "../../store/store";
import type { BrushStroke, CostMessage, CostmapMessage, Point } from "../../wire/protocol";

/** The effect of a click on a map while a group of the costmap is open. */
export type MapTool = "goal" | "keepout" | "speed" | "erase" | "cost";

/** The grid drawn over the belief, by name. */
export type Over = "costmap" | "potential";

class CostmapState {
  /** Null if no group of the costmap is open. */
  readonly tool = signal<MapTool | null>(null);
  /** The tool that is selected when such a group opens. */
  readonly lastTool = signal<MapTool>("goal");
  /** Width of the brush, m. */
  readonly brush = signal(0.5);
  /** The limit that the brush paints: the value of the speed filter's mask, 1 … 100. */
  readonly limit = signal(40);
  /** The stroke being painted. */
  readonly stroke = signal<BrushStroke | null>(null);
  /** All earlier strokes. */
  readonly painted = signal<readonly BrushStroke[]>([]);
  /** The place whose cost is explained. */
  readonly asked = signal<Point | null>(null);
  /** The grid over the belief. */
  readonly over = signal<Over | null>(null);
  /** Whether the user has ended the costmap; it then does not begin automatically. */
  readonly isEnded: Signal<boolean>;

  /** The newest messages; null before the first. */
  readonly costmap: Signal<CostmapMessage | null>;
  readonly cost: Signal<CostMessage | null>;
  readonly values: Optimistic;
  readonly #store: Store;

  constructor(store: Store) {
    const part = store.part("costmap");
    this.#store = store;
    this.costmap = part.message;
    this.values = part.values;
    this.isEnded = part.isEnded;
    this.cost = store.part("cost").message;
    this.costmap.subscribe((message) => {
      if (message?.is_on === false) this.asked.value = this.cost.value = null;
    });
  }

  /** Set the outline of the robot: corners in its frame, m. */
  setFootprint(footprint: readonly Point[]): void {
    const old = this.costmap.peek()?.footprint ?? footprint;
    this.#store.change("footprint", [{ type: "costmap", footprint: old }], [{ type: "costmap", footprint }]);
  }

  /** Set all strokes of the brush, which were `old` before the user began. */
  setKeepout(keepout: readonly BrushStroke[], old: readonly BrushStroke[]): void {
    const key = `keepout ${this.#store.history.version.peek()}`;
    this.#store.change(key, [{ type: "costmap", keepout: old }], [{ type: "costmap", keepout }]);
  }
}

export const costmapOf = (store: Store): CostmapState => store.of(CostmapState);
