import type { Geometry } from "../../wire/protocol";
import type { Cells } from "./cells";

/** A map to be drawn: its cells, and where they lie. */
export interface MapPicture {
  readonly geometry: Geometry;
  readonly cells: Cells;
  /** Name of the palette; see `palettes.ts`. */
  readonly style: string;
}
