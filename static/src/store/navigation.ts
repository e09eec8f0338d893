/** What the user does with the costmap and the path: the tool of the map, the stroke being painted, the dragged goal. */

import { type Signal, signal } from "@preact/signals";
import type { BrushStroke, CostMessage, CostmapMessage, PathMessage, Point } from "../wire/protocol";
import type { Optimistic } from "./optimistic";
import type { PartState } from "./part";

/** What a click on a map does while a group of the costmap is open. */
export type MapTool = "goal" | "keepout" | "speed" | "erase" | "cost";

/** What is laid over the belief: the name of a grid. */
export type Over = "costmap" | "potential";

export class Navigation {
  /** Null if no group of the costmap is open. */
  readonly tool = signal<MapTool | null>(null);
  /** The tool that is taken when such a group opens. */
  readonly lastTool = signal<MapTool>("goal");
  /** Width of the brush, m. */
  readonly brush = signal(0.5);
  /** The limit that the brush paints: the value of the speed filter's mask, 1 … 100. */
  readonly limit = signal(40);
  /** The stroke that is being painted. */
  readonly stroke = signal<BrushStroke | null>(null);
  /** All strokes before it. */
  readonly painted = signal<readonly BrushStroke[]>([]);
  /** Where the goal is dragged to; null while it is not. */
  readonly goalAt = signal<Point | null>(null);
  /** The place whose cost is explained. */
  readonly asked = signal<Point | null>(null);
  /** The grid over the belief. */
  readonly over = signal<Over | null>(null);
  /** Whether the user has ended the costmap: it does not begin by itself then. */
  readonly isEnded: Signal<boolean>;

  /** The newest messages; null before the first. */
  readonly costmap: Signal<CostmapMessage | null>;
  readonly path = signal<PathMessage | null>(null);
  readonly cost = signal<CostMessage | null>(null);
  /** The parameter file that was asked for. */
  readonly nav2 = signal<string | null>(null);
  readonly values: Optimistic;
  readonly #part: PartState<CostmapMessage>;

  constructor(part: PartState<CostmapMessage>) {
    this.#part = part;
    this.costmap = part.message;
    this.values = part.values;
    this.isEnded = part.isEnded;
  }

  take(message: CostmapMessage): void {
    this.#part.take(message);
    if (!message.is_on) this.asked.value = this.cost.value = null;
  }
}
