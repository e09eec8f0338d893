/** The visitor's measurement on a map and in 3D: clicked points, in metres of the map's frame. */

import { computed, signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import type { Spot } from "./model";

/** A line of points, or a polygon. */
export type MeasuringTool = "distance" | "area";

export class Measuring {
  /** The selected tool; null if none. */
  readonly tool = signal<MeasuringTool | null>(null);
  readonly points = signal<readonly Spot[]>([]);
  /** The same points from above. */
  readonly onMap = computed<readonly Point[]>(() => this.points.value.map(([x, y]) => [x, y]));
  /** Side of the largest voxel that a point is on, m; 0: all are measured points; null: all are places on a map. */
  readonly size = signal<number | null>(null);
  /** Whether the next click begins a new line. */
  readonly isDone = signal(false);
  /** Whether points snap to the borders between walls and adjacent free cells. */
  readonly snaps = signal(true);

  /** The view that announces the measurement to screen readers; null for none. */
  readonly said = signal<object | null>(null);

  /** Select a tool; null deselects it. */
  take(tool: MeasuringTool | null): void {
    this.tool.value = tool;
    this.clear();
  }

  clear(): void {
    this.points.value = [];
    this.size.value = null;
    this.isDone.value = false;
  }

  /** Add a point; `size` is the side of the voxel that it is on, null for a place on a map. */
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

/** The measurement on the maps of a page. */
export const measuringOf = (store: Store): Measuring => store.of(Measuring);
