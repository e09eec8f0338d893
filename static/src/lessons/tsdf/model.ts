/**
 * One beam along a row of voxels, as two maps keep it: log-odds of occupancy as `mapper/volume/occupancy/textbook.py`
 * adds them, and signed distances as `mapper/volume/surface/textbook.py` averages them. Metres from the sensor; voxel k
 * is from k · RESOLUTION to (k + 1) · RESOLUTION.
 *
 * Source: Hornung et al. 2013, OctoMap; Curless and Levoy 1996, section 3; Newcombe et al. 2011, section 3.3.
 */

import { logOdds } from "../../grid/cellValues";
import { normal, seeded } from "../../grid/random";

export const RESOLUTION = 0.1;
const VOXELS = 20;
export const REACH = RESOLUTION * VOXELS;
export const MOST_READINGS = 60;
/** How far the wall is moved away halfway, m. */
export const MOVE = 0.12;

/** What OctoMap adds for a beam that ends in a voxel and for one that passes it, and where it stops. */
const HIT = logOdds(0.7);
const MISS = logOdds(0.4);
export const CLAMP = { low: logOdds(0.1192), high: logOdds(0.971) } as const;

export const centreOf = (voxel: number): number => (voxel + 0.5) * RESOLUTION;

const random = seeded(1996);
const NOISE = Array.from({ length: MOST_READINGS }, () => normal(random));

/** Readings of a wall with normal noise; for those of the second half it may have been moved. */
export const readingsOf = (wall: number, count: number, sigma: number, isMoved: boolean): readonly number[] =>
  NOISE.slice(0, count).map((noise, i) => wall + (isMoved && 2 * i >= count ? MOVE : 0) + sigma * noise);

/** The log-odds of each voxel after these readings, null where no beam has been. */
export function occupancyOf(readings: readonly number[]): readonly (number | null)[] {
  const cells: (number | null)[] = Array.from({ length: VOXELS }, () => null);
  for (const z of readings) {
    const last = Math.floor(z / RESOLUTION);
    for (let k = 0; k <= Math.min(last, VOXELS - 1); k++) {
      const sum = (cells[k] ?? 0) + (k === last ? HIT : MISS);
      cells[k] = Math.min(CLAMP.high, Math.max(CLAMP.low, sum));
    }
  }
  return cells;
}

/** Voxels that are more probably occupied than free. */
export const occupiedOf = (cells: readonly (number | null)[]): readonly number[] =>
  [...cells.keys()].filter((k) => (cells[k] ?? 0) > 0);

export interface Fusion {
  /** Distance before and behind a reading within which voxels are updated, m. */
  readonly truncation: number;
  /** Weight at which the mean becomes a moving one. */
  readonly maxWeight: number;
  /** Whether voxels farther before the reading are stored too, with the truncation as their distance. */
  readonly isCarved: boolean;
  /** Whether the weight of a measurement falls to 0 from one voxel behind the reading to the truncation. */
  readonly hasDropOff: boolean;
}

export interface Voxel {
  /** Mean signed distance, m: positive before the surface. */
  readonly distance: number;
  /** 0: nothing is stored. */
  readonly weight: number;
}

/** The mean signed distance of each voxel to the readings, each with a weight of 1, or less behind it. */
export function distancesOf(
  readings: readonly number[],
  { truncation, maxWeight, isCarved, hasDropOff }: Fusion,
): readonly Voxel[] {
  const near = Math.min(RESOLUTION, truncation / 2);
  return Array.from({ length: VOXELS }, (_, k) => {
    let [distance, weight] = [0, 0];
    for (const z of readings) {
      const measured = z - centreOf(k);
      if (measured <= -truncation || (measured > truncation && !isCarved)) continue;
      const added = hasDropOff && measured < -near ? (truncation + measured) / (truncation - near) : 1;
      distance = (weight * distance + added * Math.min(measured, truncation)) / (weight + added);
      weight = Math.min(weight + added, maxWeight);
    }
    return { distance, weight };
  });
}

export interface Crossing {
  /** Metres from the sensor. */
  readonly at: number;
  /** Change of the distance per metre along the beam; −1 for one wall without noise. */
  readonly slope: number;
}

/** Where the distance falls through 0 first, by a line between two voxels; null if nowhere. */
export function zeroCrossing(voxels: readonly Voxel[]): Crossing | null {
  for (const [k, { distance, weight }] of voxels.entries()) {
    const next = voxels[k + 1];
    if (!next || weight === 0 || next.weight === 0 || distance < 0 || next.distance >= 0) continue;
    const fall = distance - next.distance;
    return { at: centreOf(k) + (RESOLUTION * distance) / fall, slope: -fall / RESOLUTION };
  }
  return null;
}
