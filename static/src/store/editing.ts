/** The selected tool for editing the world, and the edit in progress. */

import { signal } from "@preact/signals";
import type { DrawnSolid, Edits, Point } from "../wire/protocol";

export type Tool = "wall" | "box" | "erase";

export const NO_EDITS: Edits = { added: [], erased: [] };

/** The selected tool, and the shape that it is drawing. */
export class Editing {
  /** Null without a tool; a click then places the robot. */
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
