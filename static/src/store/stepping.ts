/** State of a scan that is added to the map cell by cell, for the pictures and the tools. */

import type { Cell } from "../grid/lattice";
import type { MappingConfig } from "../grid/occupancyGrid";
import type { Frame, Geometry, Pose } from "../wire/protocol";

export interface Step {
  readonly beam: number;
  /** Index of the cell on the beam, from 0, and the number of the beam's cells. */
  readonly place: number;
  readonly of: number;
  readonly cell: Cell;
  readonly evidence: number;
  readonly isHit: boolean;
  /** Bresenham's error term in this cell; null in the last. */
  readonly nabla: number | null;
}

/** A scan that is stepped through: the map does not contain it yet. */
export interface Stepping {
  readonly frame: Frame;
  /** The sensor's pose at the scan in the map frame. */
  readonly pose: Pose;
  readonly geometry: Geometry;
  readonly config: MappingConfig;
  readonly steps: readonly Step[];
  /** Number of steps done. */
  readonly done: number;
  /** Number of scans in the map; when it changes, the stepping ends. */
  readonly index: number;
}
