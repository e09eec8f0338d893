/** Beams of the newest scan: selection by direction, and points along them. */

import type { Frame, Point, Pose } from "../wire/protocol";

export interface Beam {
  readonly index: number;
  /** Bearing in the sensor's frame, radians. */
  readonly bearing: number;
  /** Metres; null for no return. */
  readonly range: number | null;
}

const TURN = 2 * Math.PI;

/** Bearing of a beam in the sensor's frame, radians. */
export const bearingOf = (frame: Frame, index: number): number =>
  frame.bearings?.[index] ?? frame.angle_min + index * frame.angle_increment;

export function beamAt(frame: Frame, index: number): Beam | null {
  const range = frame.ranges[index];
  if (range === undefined) return null;
  return { index, bearing: bearingOf(frame, index), range };
}

/** The beam nearest in bearing to a world point, for a sensor at `from`; null outside the field of view. */
export function beamToward(frame: Frame, from: Pose, [x, y]: Point): Beam | null {
  const n = frame.ranges.length;
  if (frame.bearings) return beamNear(frame, frame.bearings, Math.atan2(y - from[1], x - from[0]) - from[2]);
  const step = frame.angle_increment;
  if (n === 0 || step === 0) return null;
  const bearing = Math.atan2(y - from[1], x - from[0]) - from[2] - frame.angle_min;
  // Count from angle_min in the direction of the sweep; half a step before it still is beam 0.
  const swept = (((Math.sign(step) * bearing) % TURN) + TURN) % TURN;
  const steps = Math.round(swept / Math.abs(step));
  if (steps < n) return beamAt(frame, steps);
  return Math.round((TURN - swept) / Math.abs(step)) === 0 ? beamAt(frame, 0) : null;
}

/** The beam nearest to a bearing, at most 45° away, as `uneven_fields` in `mapper/sensors/scan.py`. */
function beamNear(frame: Frame, bearings: readonly number[], bearing: number): Beam | null {
  const off = bearings.map((other) => Math.abs(Math.atan2(Math.sin(other - bearing), Math.cos(other - bearing))));
  const nearest = off.indexOf(Math.min(...off));
  return (off[nearest] ?? TURN) <= Math.PI / 4 ? beamAt(frame, nearest) : null;
}

/** The beam nearest to straight ahead; null if there is no beam. */
export function beamAhead(frame: Frame): Beam | null {
  if (frame.bearings) {
    const off = frame.bearings.map((bearing) => 1 - Math.cos(bearing));
    return beamAt(frame, off.indexOf(Math.min(...off)));
  }
  const ahead = Math.round(-frame.angle_min / frame.angle_increment);
  return beamAt(frame, Math.min(frame.ranges.length - 1, Math.max(0, ahead)));
}

/** The frame with the bearings of a sensor that is mounted upside down. */
export const mirroredScan = (frame: Frame): Frame => ({
  ...frame,
  angle_min: -frame.angle_min,
  angle_increment: -frame.angle_increment,
  ...(frame.bearings && { bearings: frame.bearings.map((bearing) => -bearing) }),
});

/** The world point at `distance` metres along a beam. */
export function along(from: Pose, bearing: number, distance: number): Point {
  const angle = from[2] + bearing;
  return [from[0] + distance * Math.cos(angle), from[1] + distance * Math.sin(angle)];
}
