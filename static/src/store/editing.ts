/** The selected editing tool and what it is about to change. */

import { signal } from "@preact/signals";
import type { DrawnSolid, Edits, Point } from "../wire/protocol";

export type Tool = "robot" | "wall" | "box" | "erase";

export const NO_EDITS: Edits = { added: [], erased: [] };

/** What is in the hand, and what it is about to draw or erase. */
export class Editing {
  readonly tool = signal<Tool>("robot");
  /** What the stroke of the moment would draw. */
  readonly sketch = signal<DrawnSolid | null>(null);
  /** The first corner of a stroke that the keyboard draws. */
  readonly corner = signal<Point | null>(null);

  take(tool: Tool): void {
    this.tool.value = tool;
    this.sketch.value = null;
    this.corner.value = null;
  }
}
