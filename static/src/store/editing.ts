/** The selected tool that edits the world, and what it is about to change. */

import { signal } from "@preact/signals";
import type { DrawnSolid, Edits, Point } from "../wire/protocol";

export type Tool = "wall" | "box" | "erase";

export const NO_EDITS: Edits = { added: [], erased: [] };

/** The selected tool, and the shape that it is drawing. */
export class Editing {
  /** Null if no edit is wanted: a click then places the robot. */
  readonly tool = signal<Tool | null>(null);
  /** The shape of the current stroke. */
  readonly sketch = signal<DrawnSolid | null>(null);
  /** The first corner of a stroke drawn by keyboard. */
  readonly corner = signal<Point | null>(null);

  take(tool: Tool | null): void {
    this.tool.value = tool;
    this.sketch.value = null;
    this.corner.value = null;
  }
}
