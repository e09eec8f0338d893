/** A scan that is put into the map cell by cell: what the pictures and the tools show of it. */

import type { Cell } from "../grid/lattice";
import type { MappingConfig } from "../grid/occupancyGrid";
import type { Frame, Geometry, Pose } from "../wire/protocol";

export interface Step {
  readonly beam: number;
  /** Place on the beam, from 0, of so many cells. */
  readonly place: number;
  readonly of: number;
  readonly cell: Cell;
  readonly evidence: number;
  readonly isHit: boolean;
  /** Bresenham's error term in this cell; null in the last. */
  readonly nabla: number | null;
}

/** A scan that is walked through: the map has it not yet. */
export interface Walk {
  readonly frame: Frame;
  /** Where the map has the sensor at the scan. */
  readonly pose: Pose;
  readonly geometry: Geometry;
  readonly config: MappingConfig;
  readonly steps: readonly Step[];
  /** How many of the steps are done. */
  readonly done: number;
  /** Scans in the map beneath; when that is another number, the walk is over. */
  readonly index: number;
}
