/** Which beam of the newest scan is meant, and where it goes. */

import { bresenham } from "./bresenham";
import { type Cell, cellAt } from "./lattice";
import type { Frame, Geometry, Point, Pose } from "./protocol";

export interface Beam {
  readonly index: number;
  /** Bearing in the sensor's frame, radians. */
  readonly bearing: number;
  /** Metres; null for no return. */
  readonly range: number | null;
}

const TURN = 2 * Math.PI;

export function beamAt(frame: Frame, index: number): Beam | null {
  const range = frame.ranges[index];
  if (range === undefined) return null;
  return { index, bearing: frame.angle_min + index * frame.angle_increment, range };
}

/** The beam nearest in bearing to a world point, for a sensor at `from`; null where the sensor does not look. */
export function beamToward(frame: Frame, from: Pose, [x, y]: Point): Beam | null {
  const n = frame.ranges.length;
  const step = frame.angle_increment;
  if (n === 0 || step === 0) return null;
  const bearing = Math.atan2(y - from[1], x - from[0]) - from[2] - frame.angle_min;
  // Count from angle_min in the direction of the sweep; half a step before it still is beam 0.
  const swept = (((Math.sign(step) * bearing) % TURN) + TURN) % TURN;
  const steps = Math.round(swept / Math.abs(step));
  if (steps < n) return beamAt(frame, steps);
  return Math.round((TURN - swept) / Math.abs(step)) === 0 ? beamAt(frame, 0) : null;
}

/** The world point at `distance` metres along a beam. */
export function along(from: Pose, bearing: number, distance: number): Point {
  const angle = from[2] + bearing;
  return [from[0] + distance * Math.cos(angle), from[1] + distance * Math.sin(angle)];
}

/** The cells that a beam crosses, from the sensor's to the reading's or, without return, up to `range_max`. */
export function cellsOf(geometry: Geometry, from: Pose, beam: Beam, rangeMax: number): Cell[] {
  const [x, y] = along(from, beam.bearing, Math.min(beam.range ?? rangeMax, rangeMax));
  const cells: Cell[] = [];
  bresenham(cellAt(geometry, from[0], from[1]), cellAt(geometry, x, y), (row, col) => {
    cells.push({ row, col });
    return cells.length < 4096;
  });
  return cells;
}
