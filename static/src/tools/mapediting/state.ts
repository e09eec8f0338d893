/** The user's state while editing a map: the tool, the current drawing, and the edits so far. */

import { batch, type ReadonlySignal, signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { MapEditsMessage, Point } from "../../wire/protocol";

export type MapTool = "brush" | "line" | "area" | "keepout" | "speed" | "straighten" | "crop" | "origin";

/** The new state of a cell. */
export type PaintedState = "occupied" | "free" | "unknown";

class MapEditing {
  /** Null if the pointer moves the picture. */
  readonly tool = signal<MapTool | null>("brush");
  readonly state = signal<PaintedState>("occupied");
  /** Width of the brush and of lines, m. */
  readonly width = signal(0.1);
  /** Whether areas and zones are drawn freely; otherwise they are rectangles. */
  readonly isFreehand = signal(false);
  /** Whether the keepout tool removes zones instead of adding them. */
  readonly allows = signal(false);
  /** The mask value of the speed filter that the speed limit tool sets, 1 to 100; 0 is no limit. */
  readonly limit = signal(50);
  /** The current drawing, or one that was sent and is not yet in the map. */
  readonly sketch = signal<readonly Point[] | null>(null);
  /** Whether the sketch was sent. */
  readonly isSent = signal(false);
  /** The first corner set by keyboard. */
  readonly corner = signal<Point | null>(null);
  /** The angle by which the map will be rotated, rad; null while none is being chosen. */
  readonly turn = signal<number | null>(null);
  /** The newest message; null before the first. */
  readonly edits: ReadonlySignal<MapEditsMessage | null>;

  constructor(store: Store) {
    this.edits = store.part("map_edits").message;
    this.edits.subscribe(() => {
      if (this.isSent.peek()) this.drop();
    });
    store.notice.subscribe((notice) => {
      if (notice?.kind === "error") this.drop();
    });
  }

  /** Choose a tool; null for none. */
  choose(tool: MapTool | null): void {
    batch(() => {
      this.tool.value = tool;
      this.drop();
    });
  }

  /** Discard the drawing. */
  drop(): void {
    batch(() => {
      this.sketch.value = this.corner.value = null;
      this.isSent.value = false;
    });
  }
}

export const mapEditingOf = (store: Store): MapEditing => store.of(MapEditing);
