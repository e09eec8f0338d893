/** The logs of the fleet as the service tells them, and which of them are shown in what order. */

import { plural } from "../../ui/numbers";
import type { ClusterState, FleetFacts, FleetFinding, FleetLog, FleetState } from "../../wire/http";

export type { FleetFinding as Finding, FleetLog };
export type Facts = FleetFacts;
export type Counts = FleetState["counts"];
export type Cluster = ClusterState;
export type FleetAnswer = FleetState;

/** The logs after an answer: those of an earlier one with what has changed. */
export function merged(known: ReadonlyMap<string, FleetLog> | null, answer: FleetAnswer): Map<string, FleetLog> {
  const next = new Map(answer.whole ? [] : (known ?? []));
  for (const log of answer.logs) next.set(log.id, log);
  return next;
}

/** Where logs are mapped, and how many at once. */
export function placeOf(cluster: Cluster | null, workers: number): string {
  if (cluster === null) return `On this server, ${plural(workers, "log")} at once.`;
  return `On a Dask cluster with ${plural(cluster.workers, "worker")}, ${plural(cluster.threads, "log")} at once.`;
}

/** What keeps the cluster from mapping, and what happens to the logs; null where it is well. */
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

export const ORDERS = [
  { value: "name", label: "by name" },
  { value: "findings", label: "most findings first" },
  { value: "contrast", label: "least sharp first" },
  { value: "scans", label: "most scans first" },
  { value: "size", label: "largest map first" },
] as const;
export type Order = (typeof ORDERS)[number]["value"];

const area = ({ rows, cols, resolution }: Facts): number => rows * cols * resolution ** 2;

const KEYS: Record<Exclude<Order, "name">, (facts: Facts) => number> = {
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

/**
 * The logs to be shown, in order. By name each keeps its place while it is mapped; in another order those without a map
 * come last.
 */
export function chosen(logs: Iterable<FleetLog>, words: string, shown: Shown, order: Order): FleetLog[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  const rank = (log: FleetLog): number => ["done", "failed", "running", "queued", "none"].indexOf(log.state);
  const found = [...logs].filter((log) => {
    const text = [log.name, log.error?.message, ...(log.facts?.findings ?? []).map((one) => one.sentence)]
      .join(" ")
      .toLowerCase();
    return IS_SHOWN[shown](log) && wanted.every((word) => text.includes(word));
  });
  return found.sort((a, b) => {
    if (order !== "name") {
      const first = rank(a) - rank(b) || (a.facts && b.facts ? KEYS[order](b.facts) - KEYS[order](a.facts) : 0);
      if (first !== 0) return first;
    }
    return a.name.localeCompare(b.name, "en", { numeric: true });
  });
}
