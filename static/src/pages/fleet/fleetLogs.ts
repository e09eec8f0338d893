/** The logs of the fleet from the service, and the selection and order of those shown. */

import { signal } from "@preact/signals";
import { plural } from "../../ui/numbers";
import { ask, whyAgain } from "../../wire/ask";
import type { ClusterState, FleetFacts, FleetFinding, FleetLog, FleetOptions, FleetState } from "../../wire/http";

/** Interval of requests while logs are being mapped, and otherwise. */
const BUSY_MS = 700;
const IDLE_MS = 5000;

/** The logs by id; null before the first answer. */
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
    // A log was added or deleted: all are requested.
    revision = next.size === totalOf(answer.counts) ? answer.revision : 0;
    again = isBusy(answer.counts) ? BUSY_MS : IDLE_MS;
  } catch (error) {
    fleetError.value = whyAgain(error);
    revision = 0; // the service may have been replaced by another
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

/**
 * Map the logs that have no map; with `again` also those that failed; with `options` also those mapped with others.
 * Rejects with the server's sentence.
 */
export async function mapAll(again: boolean, options: FleetOptions | null = null): Promise<void> {
  const asked = ask("POST /api/fleet", {}, { body: { again, options } });
  await refresh();
  await asked;
  await refresh();
}

/** Stop mapping. Rejects with the server's sentence. */
export async function stopMapping(): Promise<void> {
  await ask("DELETE /api/fleet", {});
  await refresh();
}

export type { FleetFinding as Finding, FleetLog };
export type Facts = FleetFacts;
export type Counts = FleetState["counts"];
type Cluster = ClusterState;
type FleetAnswer = FleetState;

/** The logs after an answer: the earlier ones with the changes. */
export function merged(known: ReadonlyMap<string, FleetLog> | null, answer: FleetAnswer): Map<string, FleetLog> {
  const next = new Map(answer.whole ? [] : (known ?? []));
  for (const log of answer.logs) next.set(log.id, log);
  return next;
}

/** Where logs are mapped, and how many at the same time. */
export function placeOf(cluster: Cluster | null, workers: number): string {
  if (cluster === null) return `On this server, ${plural(workers, "log")} at once.`;
  return `On a Dask cluster with ${plural(cluster.workers, "worker")}, ${plural(cluster.threads, "log")} at once.`;
}

/** What prevents the cluster from mapping, and what happens to the logs; null if nothing does. */
export function troubleOf(cluster: Cluster | null, all: Counts): string | null {
  if (cluster === null || cluster.error === "") return null;
  if (cluster.threads > 0 || all.queued + all.running === 0) return cluster.error;
  return `${cluster.error} Logs that are not mapped yet wait, and go on by themselves.`;
}

export const SHOWN = [
  { value: "all", label: "All" },
  { value: "findings", label: "With findings" },
  { value: "failed", label: "Failed" },
  { value: "open", label: "Not mapped yet" },
] as const;
export type Shown = (typeof SHOWN)[number]["value"];

/** The least drift of the logs that are shown, metres. */
export const DRIFTS = [
  { value: "0", label: "any drift" },
  { value: "0.1", label: "drift of 0.1 m or more" },
  { value: "0.3", label: "drift of 0.3 m or more" },
  { value: "1", label: "drift of 1 m or more" },
] as const;

export const ANY = "any";

/** The doctor's findings in a few words. */
const FINDINGS: Readonly<Record<string, string>> = {
  "clock.backwards": "time runs backwards",
  "clock.doubled": "two scans at one time",
  "clock.dropped": "missing scans",
  "clock.gap": "gap in the recording",
  "clock.jitter": "irregular scans",
  "clock.unit": "wrong unit of time",
  "mount.between": "mounts of two lidars",
  "mount.offset": "sensor offset",
  "mount.changing": "sensor’s mount changes",
  "mount.turned": "sensor turned",
  "poses.still": "poses stay in place",
  "readings.few": "few readings",
  "readings.itself": "beams hit the robot",
  "readings.max_range": "no return stored as a range",
  "timing.clock": "clock of the poses",
  "timing.delay": "delay",
  "timing.increment": "motion within a scan",
  "timing.sparse": "poses far apart in time",
  "walls.drift": "drift",
  "walls.moving": "moving things",
};

/** The first findings of the logs by name, each with its number of logs, as options of a menu. */
export function firstFindings(logs: Iterable<FleetLog>): readonly { readonly value: string; readonly label: string }[] {
  const counts = new Map<string, number>();
  for (const { facts } of logs) {
    const check = facts?.findings[0]?.check;
    if (check !== undefined) counts.set(check, (counts.get(check) ?? 0) + 1);
  }
  const options = [...counts].map(([check, count]) => ({
    value: check,
    label: `${FINDINGS[check] ?? check} (${count})`,
  }));
  options.sort((option, other) => option.label.localeCompare(other.label, "en"));
  return [{ value: ANY, label: "any finding" }, ...options];
}

export const ORDERS = [
  { value: "name", label: "by name" },
  { value: "drift", label: "most drift first" },
  { value: "findings", label: "most findings first" },
  { value: "contrast", label: "least sharp first" },
  { value: "scans", label: "most scans first" },
  { value: "size", label: "largest map first" },
] as const;
export type Order = (typeof ORDERS)[number]["value"];

const area = ({ rows, cols, resolution }: Facts): number => rows * cols * resolution ** 2;

const KEYS: Record<Exclude<Order, "name">, (facts: Facts) => number> = {
  drift: (facts) => facts.drift_m ?? -1,
  findings: (facts) => facts.findings.length,
  contrast: (facts) => -(facts.contrast ?? 1),
  scans: (facts) => facts.scans,
  size: area,
};

const IS_SHOWN: Record<Shown, (log: FleetLog) => boolean> = {
  all: () => true,
  findings: (log) => (log.facts?.findings.length ?? 0) > 0,
  failed: (log) => log.state === "failed",
  open: (log) => log.state !== "done" && log.state !== "failed",
};

/** Which logs are shown. */
export interface Wanted {
  readonly words: string;
  readonly shown: Shown;
  /** Metres. */
  readonly drift: number;
  /** Name of the first finding, or {@link ANY}. */
  readonly finding: string;
}

export const EVERY: Wanted = { words: "", shown: "all", drift: 0, finding: ANY };

const isWanted = ({ facts }: FleetLog, { drift, finding }: Wanted): boolean =>
  (drift === 0 || (facts?.drift_m ?? 0) >= drift) && (finding === ANY || facts?.findings[0]?.check === finding);

/**
 * The logs to be shown, in order. Sorted by name, each keeps its place while it is mapped; in another order those
 * without a map come last.
 */
export function chosen(logs: Iterable<FleetLog>, wanted: Wanted, order: Order): FleetLog[] {
  const words = wanted.words.toLowerCase().split(/\s+/).filter(Boolean);
  const rank = (log: FleetLog): number => ["done", "failed", "running", "queued", "none"].indexOf(log.state);
  const matching = [...logs].filter((log) => {
    const text = [log.name, log.error?.message, ...(log.facts?.findings ?? []).map((finding) => finding.sentence)]
      .join(" ")
      .toLowerCase();
    return IS_SHOWN[wanted.shown](log) && isWanted(log, wanted) && words.every((word) => text.includes(word));
  });
  return matching.sort((a, b) => {
    if (order !== "name") {
      const first = rank(a) - rank(b) || (a.facts && b.facts ? KEYS[order](b.facts) - KEYS[order](a.facts) : 0);
      if (first !== 0) return first;
    }
    return a.name.localeCompare(b.name, "en", { numeric: true });
  });
}
