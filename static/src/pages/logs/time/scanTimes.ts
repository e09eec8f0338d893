/** Conversion between scans and times. The trajectory has the times of scans 0, `every`, 2 · `every` … */

import type { Store } from "../../../store/store";
import { selectionOf } from "../../../tools/scene/selection";
import type { Trajectory } from "../../../wire/protocol";

type Times = Pick<Trajectory, "stamps" | "every">;

/**
 * Recorded time when `index` scans are in the map, s from the first scan, interpolated linearly between known times.
 */
export function secondsAt({ stamps, every }: Times, index: number): number {
  const place = Math.max(0, index - 1) / every;
  const low = Math.floor(place);
  const from = stamps[Math.min(low, stamps.length - 1)] ?? 0;
  const to = stamps[low + 1] ?? from;
  return from + (place - low) * (to - from);
}

/** The number of scans in the map at a time: those until then, at least one. */
export function scansAt({ stamps, every }: Times, seconds: number, count: number): number {
  let low = 0; // the first later known time
  let high = stamps.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((stamps[middle] ?? 0) <= seconds + 5e-4) low = middle + 1;
    else high = middle;
  }
  if (low === 0) return Math.min(1, count);
  const from = stamps[low - 1] ?? 0;
  const to = stamps[low] ?? from;
  const beyond = to > from ? Math.floor(((seconds - from) / (to - from)) * every + 1e-6) : every - 1;
  return Math.min(count, (low - 1) * every + Math.min(every - 1, Math.max(0, beyond)) + 1);
}

interface Moment {
  /** From 0. */
  readonly scan: number;
  /** From the first scan. */
  readonly seconds: number;
}

/**
 * When the selection of all views was measured: by the selected beam, initially the last that updated the cell, or by
 * the scans.
 */
export function selectedMoments(store: Store): readonly Moment[] {
  const selection = selectionOf(store).value;
  if (selection?.what === "cell") {
    const beam = store.selectedContribution.value;
    return beam ? [{ scan: beam.scan, seconds: beam.stamp }] : [];
  }
  const trajectory = store.trajectory.value;
  if (!trajectory || !selection) return [];
  return selection.scans.map((scan) => ({ scan, seconds: secondsAt(trajectory, scan + 1) }));
}
