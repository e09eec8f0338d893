/** What the user does with a map that is edited: the tool, what is being drawn, and the edits so far. */

import { batch, type ReadonlySignal, signal } from "@preact/signals";
import type { Store } from "../../store/store";
import type { MapEditsMessage, Point } from "../../wire/protocol";

export type MapTool = "brush" | "line" | "area" | "keepout" | "speed" | "straighten" | "crop" | "origin";

/** What a cell becomes. */
export type PaintedState = "occupied" | "free" | "unknown";

class MapEditing {
  /** Null if the pointer moves the picture. */
  readonly tool = signal<MapTool | null>("brush");
  readonly state = signal<PaintedState>("occupied");
  /** Width of the brush and of lines, m. */
  readonly width = signal(0.1);
  /** Whether areas and zones are drawn freely; else they are rectangles. */
  readonly isFreehand = signal(false);
  /** Whether the tool of keepout zones allows what was forbidden. */
  readonly allows = signal(false);
  /** Value of the speed filter's mask that the tool of speed limits sets, 1 … 100; 0 is no limit. */
  readonly limit = signal(50);
  /** What is being drawn, or was sent and is not yet in the map. */
  readonly sketch = signal<readonly Point[] | null>(null);
  /** Whether the sketch was sent. */
  readonly isSent = signal(false);
  /** The first corner that the keyboard has set. */
  readonly corner = signal<Point | null>(null);
  /** By how much the map will be turned, rad; null while this is not chosen. */
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

  /** Draw nothing any more. */
  drop(): void {
    batch(() => {
      this.sketch.value = this.corner.value = null;
      this.isSent.value = false;
    });
  }
}

export const mapEditingOf = (store: Store): MapEditing => store.of(MapEditing);
