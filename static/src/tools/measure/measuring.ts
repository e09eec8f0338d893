/** What the visitor measures on a map and in 3D: points that were clicked, in metres of the map's frame. */

import { computed, signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import type { Spot } from "./model";

/** A line of points, or a polygon. */
export type MeasuringTool = "distance" | "area";

export class Measuring {
  /** The tool in use; null while nothing is measured. */
  readonly tool = signal<MeasuringTool | null>(null);
  readonly points = signal<readonly Spot[]>([]);
  /** The same points, seen from above. */
  readonly onMap = computed<readonly Point[]>(() => this.points.value.map(([x, y]) => [x, y]));
  /** Side of the largest voxel that a point is on, m; 0: all are measured points; null: all are places of a map. */
  readonly size = signal<number | null>(null);
  /** Whether the next click begins a new line. */
  readonly isDone = signal(false);
  /** Whether points snap to the borders between walls and what is free beside them. */
  readonly snaps = signal(true);

  /** The view whose statement of it screen readers are told by; null for none. */
  readonly said = signal<object | null>(null);

  /** Take a tool, or put it away with null. */
  take(tool: MeasuringTool | null): void {
    this.tool.value = tool;
    this.clear();
  }

  clear(): void {
    this.points.value = [];
    this.size.value = null;
    this.isDone.value = false;
  }

  /** Add a point; `size` is the side of the voxel that it is on, null for a place of a map. */
  add(point: Spot, size: number | null = null): void {
    if (this.isDone.peek()) this.clear();
    this.points.value = [...this.points.peek(), point];
    if (size !== null) this.size.value = Math.max(size, this.size.peek() ?? 0);
  }

  undo(): void {
    this.points.value = this.points.peek().slice(0, -1);
    this.isDone.value = false;
  }
}

/** What is measured on the maps of a page. */
export const measuringOf = (store: Store): Measuring => store.of(Measuring);
