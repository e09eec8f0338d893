/** What the visitor measures on a map: points that were clicked, in metres of the map's frame. */

import { signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";

/** A line of points, or a polygon. */
export type MeasuringTool = "distance" | "area";

class Measuring {
  /** The tool in use; null while nothing is measured. */
  readonly tool = signal<MeasuringTool | null>(null);
  readonly points = signal<readonly Point[]>([]);
  /** Whether the next click begins anew. */
  readonly isDone = signal(false);
  /** Whether points snap to the borders between walls and what is free beside them. */
  readonly snaps = signal(true);

  /** Take a tool, or put it away with null. */
  take(tool: MeasuringTool | null): void {
    this.tool.value = tool;
    this.clear();
  }

  clear(): void {
    this.points.value = [];
    this.isDone.value = false;
  }

  add(point: Point): void {
    this.points.value = this.isDone.peek() ? [point] : [...this.points.peek(), point];
    this.isDone.value = false;
  }

  undo(): void {
    this.points.value = this.points.peek().slice(0, -1);
    this.isDone.value = false;
  }
}

/** What is measured on the maps of a page. */
export const measuringOf = (store: Store): Measuring => store.of(Measuring);
