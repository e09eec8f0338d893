/** Step by step: on and back by a cell or a beam of the newest scan, by a scan, by a second. */

import { effect } from "@preact/signals";
import { logOddsAt, shownByteAt } from "../../grid/cellValues";
import type { Cell } from "../../grid/lattice";
import type { Store } from "../../store/store";
import type { Walk } from "../../store/walk";
import { toast } from "../../ui/Toast";
import { lessonConfig, moved, stepsOfScan, valuesAfterSteps, whyNoSteps } from "./model";

export const UNITS = ["cell", "beam", "scan", "second"] as const;
export type Unit = (typeof UNITS)[number];

/** How long an answer may take before the step is given up. */
const PATIENCE_MS = 4000;

/** Wait until the map holds another number of scans; false where none comes. */
function indexChanged(store: Store): Promise<boolean> {
  const before = store.frame.peek()?.index;
  return new Promise((resolve) => {
    const done = (result: boolean): void => {
      clearTimeout(timer);
      queueMicrotask(() => stop());
      resolve(result);
    };
    const timer = setTimeout(() => done(false), PATIENCE_MS);
    const stop = effect(() => {
      if (store.frame.value?.index !== before) done(true);
    });
  });
}

/** Take the newest scan out of the map, to be put back cell by cell; `onwards` takes a scan first. */
async function begin(store: Store, onwards: boolean): Promise<Walk | null> {
  const why = whyNoSteps(store.mapping.values.peek());
  if (why) {
    toast(why);
    return null;
  }
  if (onwards || store.playing.peek()) {
    store.send({ type: "step", scans: 1 });
    if (!(await indexChanged(store))) return null;
  }
  const frame = store.beliefFrame.peek();
  const pose = store.beliefPose.peek();
  store.send({ type: "step", scans: -1 });
  if (!(await indexChanged(store))) return null;
  const geometry = store.map.peek()?.geometry;
  const index = store.frame.peek()?.index;
  if (!frame || !pose || !geometry || index === undefined) return null;
  const config = lessonConfig(store.mapping.values.peek());
  const steps = stepsOfScan(frame, pose, geometry, config);
  return { frame, pose, geometry, config, steps, index, done: onwards ? 0 : steps.length };
}

let busy = false;

/** Go a step on or back. Steps that come while one waits for the server are dropped. */
export async function step(store: Store, unit: Unit, by: 1 | -1): Promise<void> {
  if (busy) return;
  const walk = store.walk.peek();
  if (unit === "scan" || unit === "second") {
    const scans = unit === "scan" ? 1 : Math.round(Number(store.sensor.values.peek().scan_rate ?? 10));
    // A scan that was walked through is in the map as far as the eye goes: on means the rest of it.
    store.walk.value = null;
    store.send({ type: "step", scans: by * scans });
    return;
  }
  if (walk && by === 1 && walk.done === walk.steps.length) {
    store.walk.value = null;
    store.send({ type: "step", scans: 1 });
    return;
  }
  busy = true;
  try {
    const from = walk ?? (await begin(store, by === 1));
    if (from) store.walk.value = { ...from, done: moved(from, unit, by) };
  } finally {
    busy = false;
  }
}

/** What the map beneath a walk holds of a cell; the prior where it was never seen. */
export function valueBeforeWalk(store: Store, { geometry, config }: Walk, { row, col }: Cell): number {
  const byte = store.map.peek()?.cells.at(row, col) ?? 0;
  if (byte === 0) return config.log_odds_prior;
  const exact = store.inspected.peek();
  if (exact?.row === row && exact.col === col && exact.epoch === store.map.peek()?.geometry.epoch) {
    // Of the cell that the server was asked about more is known than a byte says, while it is still the same byte; the
    // first and the last byte stand for all that lies beyond them, where nothing is clamped.
    if (Math.abs(shownByteAt(exact.log_odds, geometry) - byte) <= 0.51) return exact.log_odds;
  }
  return logOddsAt(byte, geometry);
}

/** What every cell that the walk has touched holds now. */
export const valuesNow = (store: Store, walk: Walk): ReadonlyMap<string, number> =>
  valuesAfterSteps(walk, (cell) => valueBeforeWalk(store, walk, cell));

/** End the walk when time goes on, or the map beneath becomes another; the result stops that. */
export function endStaleWalk(store: Store): () => void {
  const stops = [
    effect(() => {
      const frame = store.frame.value;
      const walk = store.walk.peek();
      if (walk && frame && (frame.index !== walk.index || frame.playing)) store.walk.value = null;
    }),
    effect(() => {
      void store.mapping.values.value;
      if (store.walk.peek()) store.walk.value = null;
    }),
    effect(() => {
      const walk = store.walk.value;
      const cell = walk?.steps[walk.done - 1]?.cell;
      if (cell) store.inspect(cell);
    }),
  ];
  return () => {
    for (const stop of stops) stop();
  };
}
