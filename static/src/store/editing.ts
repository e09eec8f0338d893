/** The selected tool that edits the world, and what it is about to change. */

import { signal } from "@preact/signals";
import type { DrawnSolid, Edits, Point } from "../wire/protocol";

export type Tool = "wall" | "box" | "erase";

export const NO_EDITS: Edits = { added: [], erased: [] };

/** The selected tool, and what it is about to draw or erase. */
export class Editing {
  /** Null where no edit is wanted: a click then places the robot. */
  readonly tool = signal<Tool | null>(null);
  /** What the stroke of the moment would draw. */
  readonly sketch = signal<DrawnSolid | null>(null);
  /** The first corner of a stroke that the keyboard draws. */
  readonly corner = signal<Point | null>(null);

  take(tool: Tool | null): void {
    this.tool.value = tool;
    this.sketch.value = null;
    this.corner.value = null;
  }
}
