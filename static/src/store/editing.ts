/** The selected editing tool and what it is about to change. */

import { signal } from "@preact/signals";
import type { DrawnSolid, Edits, Point } from "../wire/protocol";

export type Tool = "robot" | "wall" | "box" | "erase";

export const NO_EDITS: Edits = { added: [], erased: [] };

/** The selected tool, and the shape that it is drawing. */
export class Editing {
  readonly tool = signal<Tool>("robot");
  /** The shape of the current stroke. */
  readonly sketch = signal<DrawnSolid | null>(null);
  /** The first corner of a stroke drawn by keyboard. */
  readonly corner = signal<Point | null>(null);

  take(tool: Tool): void {
    this.tool.value = tool;
    this.sketch.value = null;
    this.corner.value = null;
  }
}
