/** Stepping forward and back by a cell or a beam of the newest scan, by a scan, or by a second. */

import { effect } from "@preact/signals";
import { logOddsAt, shownByteAt } from "../../grid/cellValues";
import type { Cell } from "../../grid/lattice";
import type { Stepping } from "../../store/sessionSignals";
import type { Store } from "../../store/store";
import { toast } from "../../ui/Toast";
import { lessonConfig, moved, stepsOfScan, valuesAfterSteps, whyNoSteps } from "./model";

export const UNITS = ["cell", "beam", "scan", "second"] as const;
export type Unit = (typeof UNITS)[number];

/** Timeout of the server's answer to a step. A busy server, or a map that is recomputed, takes seconds. */
const TIMEOUT_MS = 60_000;

/** Wait until the number of scans in the map changes; false when the server refuses, or after the timeout. */
function indexChanged(store: Store): Promise<boolean> {
  const before = store.frame.peek()?.index;
  const noticeBefore = store.notice.peek();
  return new Promise((resolve) => {
    const done = (result: boolean): void => {
      clearTimeout(timer);
      queueMicrotask(() => stop());
      resolve(result);
    };
    const timer = setTimeout(() => {
      toast("The server has not answered the step. Please try again.");
      done(false);
    }, TIMEOUT_MS);
    const stop = effect(() => {
      if (store.frame.value?.index !== before) done(true);
      else if (store.notice.value !== noticeBefore && store.notice.value?.kind === "error") done(false);
    });
  });
}

/** Remove the newest scan from the map, to add it again cell by cell; with `onwards`, first take a new scan. */
async function begin(store: Store, onwards: boolean): Promise<Stepping | null> {
  const why = whyNoSteps(store.mapping.values.peek());
  if (why) {
    toast(why);
    return null;
  }
  if (onwards || store.playing.peek()) {
    store.send({ type: "step", scans: 1 });
    if (!(await indexChanged(store))) return null;
  }
  if (store.frame.peek()?.index === 0) return null;
  const frame = store.beliefFrame.peek();
  const pose = store.beliefPose.peek();
  store.send({ type: "step", scans: -1 });
  if (!(await indexChanged(store))) return null;
  const geometry = store.map.peek()?.geometry;
  const index = store.frame.peek()?.index;
  if (!frame || !pose || !geometry || index === undefined) return null;
  const values = store.mapping.values.peek();
  const config = lessonConfig(values);
  const steps = stepsOfScan(frame, pose, geometry, config, values.hit_and_passed === "only_hits");
  return { frame, pose, geometry, config, steps, index, done: onwards ? 0 : steps.length };
}

let busy = false;

/** Step forward or back. Steps that are requested while one waits for the server are dropped. */
export async function step(store: Store, unit: Unit, by: 1 | -1): Promise<void> {
  if (busy) return;
  const stepping = store.stepping.peek();
  if (unit === "scan" || unit === "second") {
    const scans = unit === "scan" ? 1 : Math.round(Number(store.sensor.values.peek().scan_rate ?? 10));
    // A scan that was stepped through is displayed as if it were in the map, so stepping forward adds it.
    store.stepping.value = null;
    store.send({ type: "step", scans: by * scans });
    return;
  }
  if (stepping && by === 1 && stepping.done === stepping.steps.length) {
    store.stepping.value = null;
    store.send({ type: "step", scans: 1 });
    return;
  }
  busy = true;
  try {
    const from = stepping ?? (await begin(store, by === 1));
    if (from) store.stepping.value = { ...from, done: moved(from, unit, by) };
  } finally {
    busy = false;
  }
}

/** The log-odds of a cell in the map without the scan that is stepped through; the prior if it was never observed. */
export function valueBeforeSteps(store: Store, { geometry, config }: Stepping, { row, col }: Cell): number {
  const byte = store.map.peek()?.cells.at(row, col) ?? 0;
  if (byte === 0) return config.log_odds_prior;
  const exact = store.inspected.peek();
  if (exact?.row === row && exact.col === col && exact.epoch === store.map.peek()?.geometry.epoch) {
    // The exact value from the server is used while it agrees with the cell's byte. Without a clamp, the first and the
    // last byte stand for all values beyond them.
    if (Math.abs(shownByteAt(exact.log_odds, geometry) - byte) <= 0.51) return exact.log_odds;
  }
  return logOddsAt(byte, geometry);
}

/** The current log-odds of every cell that the steps have updated. */
export const valuesNow = (store: Store, stepping: Stepping): ReadonlyMap<string, number> =>
  valuesAfterSteps(stepping, (cell) => valueBeforeSteps(store, stepping, cell));

/** End the stepping when the session advances or the map changes; the returned function stops this. */
export function endStaleSteps(store: Store): () => void {
  const stops = [
    effect(() => {
      const frame = store.frame.value;
      const stepping = store.stepping.peek();
      if (stepping && frame && (frame.index !== stepping.index || frame.playing)) store.stepping.value = null;
    }),
    effect(() => {
      void store.mapping.values.value;
      if (store.stepping.peek()) store.stepping.value = null;
    }),
    effect(() => {
      const stepping = store.stepping.value;
      const cell = stepping?.steps[stepping.done - 1]?.cell;
      if (cell) store.inspect(cell);
    }),
  ];
  return () => {
    for (const stop of stops) stop();
  };
}
