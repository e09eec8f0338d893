/** The state of the fleet, asked for while it changes. */

import { signal } from "@preact/signals";
import { ask } from "../../wire/ask";
import { type Cluster, type Counts, type FleetLog, merged } from "./fleetLogs";

/** Time between two requests while logs are being mapped, and while none are. */
const BUSY_MS = 700;
const IDLE_MS = 5000;

/** The logs by id; null until they were first fetched. */
export const fleetLogs = signal<ReadonlyMap<string, FleetLog> | null>(null);
export const counts = signal<Counts>({ none: 0, queued: 0, running: 0, done: 0, failed: 0 });
export const workers = signal(1);
export const cluster = signal<Cluster | null>(null);
export const fleetError = signal<string | null>(null);

export const totalOf = (all: Counts): number => all.none + all.queued + all.running + all.done + all.failed;
export const isBusy = (all: Counts): boolean => all.queued + all.running > 0;

let revision = 0;
let timer: ReturnType<typeof setTimeout> | undefined;
let isWatched = false;

async function refresh(): Promise<void> {
  clearTimeout(timer);
  let again = 3000;
  try {
    const answer = await ask("GET /api/fleet", {}, { query: { since: revision } });
    const next = merged(fleetLogs.peek(), answer);
    fleetLogs.value = next;
    counts.value = answer.counts;
    workers.value = answer.workers;
    cluster.value = answer.cluster;
    fleetError.value = null;
    // A log that was added or is gone: all of them are asked for.
    revision = next.size === totalOf(answer.counts) ? answer.revision : 0;
    again = isBusy(answer.counts) ? BUSY_MS : IDLE_MS;
  } catch (error) {
    fleetError.value = (error as Error).message;
    revision = 0; // the service may be another one now
  }
  if (isWatched) timer = setTimeout(() => void refresh(), document.hidden ? 5 * again : again);
}

/** Keep the state up to date until the returned function is called. */
export function watchFleet(): () => void {
  isWatched = true;
  void refresh();
  return () => {
    isWatched = false;
    clearTimeout(timer);
  };
}

/** Map what was not mapped yet; `again`: also what failed. Rejects with the server's sentence. */
export async function mapAll(again: boolean): Promise<void> {
  const asked = ask("POST /api/fleet", {}, { body: { again } });
  await refresh();
  await asked;
  await refresh();
}

/** Map no more. Rejects with the server's sentence. */
export async function stopMapping(): Promise<void> {
  await ask("DELETE /api/fleet", {});
  await refresh();
}
