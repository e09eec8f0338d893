import { expect, test } from "vitest";
import { ANY, chosen, EVERY, type FleetLog, firstFindings, merged, placeOf, troubleOf } from "./fleetLogs";

const log = (name: string, more: Partial<FleetLog> = {}): FleetLog => ({
  id: `id of ${name}`,
  name,
  state: "none",
  has_picture: false,
  fraction: 0,
  error: null,
  facts: null,
  options: "",
  ...more,
});

const mapped = (name: string, scans: number, ...sentences: string[]): FleetLog =>
  log(name, {
    state: "done",
    facts: {
      scans,
      beams: 180,
      rows: 10,
      cols: 10,
      resolution: 0.1,
      contrast: 0.5,
      findings: sentences.map((sentence) => ({ check: "mount", sentence, possible: false })),
      picture: true,
      trajectory: "odom",
      cpu_s: 1,
      seconds: 1,
      runs: 1,
      drift_m: null,
    },
  });

const LOGS = [
  log("run 10"),
  mapped("run 9", 50, "The lidar is turned."),
  log("yard", { state: "failed", error: { code: "log.no_scans", message: "The log holds no scans." } }),
  mapped("run 2", 90),
  log("run 1", { state: "running", fraction: 0.5 }),
];
const names = (logs: readonly FleetLog[]): string[] => logs.map((log) => log.name);

test("an answer replaces what has changed, and all where it is whole", () => {
  const counts = { none: 0, queued: 0, running: 0, done: 1, failed: 0 };
  const answer = { revision: 3, whole: false, workers: 1, cluster: null, counts, logs: [mapped("run 10", 7)] };
  const known = new Map(LOGS.map((log) => [log.id, log]));
  const next = merged(known, answer);
  expect(next.size).toBe(5);
  expect(next.get("id of run 10")?.facts?.scans).toBe(7);
  expect([...merged(known, { ...answer, whole: true }).keys()]).toEqual(["id of run 10"]);
});

test("by name each log keeps its place; otherwise those without a map come last", () => {
  expect(names(chosen(LOGS, EVERY, "name"))).toEqual(["run 1", "run 2", "run 9", "run 10", "yard"]);
  expect(names(chosen(LOGS, EVERY, "scans"))).toEqual(["run 2", "run 9", "yard", "run 1", "run 10"]);
  expect(names(chosen(LOGS, EVERY, "findings"))).toEqual(["run 9", "run 2", "yard", "run 1", "run 10"]);
});

test("logs are found by words of name, finding and reason, and by result", () => {
  expect(names(chosen(LOGS, { ...EVERY, words: "TURNED run" }, "name"))).toEqual(["run 9"]);
  expect(names(chosen(LOGS, { ...EVERY, words: "no scans" }, "name"))).toEqual(["yard"]);
  expect(names(chosen(LOGS, { ...EVERY, shown: "failed" }, "name"))).toEqual(["yard"]);
  expect(names(chosen(LOGS, { ...EVERY, shown: "findings" }, "name"))).toEqual(["run 9"]);
  expect(names(chosen(LOGS, { ...EVERY, shown: "open" }, "name"))).toEqual(["run 1", "run 10"]);
});

test("logs are found by drift and by their first finding, and ordered by drift", () => {
  const drifted = (name: string, drift_m: number | null, ...checks: string[]): FleetLog => {
    const log = mapped(name, 10, ...checks);
    const findings = checks.map((check) => ({ check, sentence: check, possible: false }));
    return { ...log, facts: log.facts && { ...log.facts, drift_m, findings } };
  };
  const logs = [
    log("unmapped"),
    drifted("straight", 0.1, "clock.gap"),
    drifted("bent", 1.25, "walls.drift", "clock.gap"),
    drifted("unmeasured", null),
    drifted("pushed", 0.3, "walls.drift"),
  ];
  const order = ["bent", "pushed", "straight", "unmeasured", "unmapped"];
  expect(names(chosen(logs, EVERY, "drift"))).toEqual(order);
  expect(names(chosen(logs, { ...EVERY, drift: 0.3 }, "drift"))).toEqual(["bent", "pushed"]);
  expect(names(chosen(logs, { ...EVERY, finding: "clock.gap" }, "name"))).toEqual(["straight"]);
  expect(firstFindings(logs)).toEqual([
    { value: ANY, label: "any finding" },
    { value: "walls.drift", label: "drift (2)" },
    { value: "clock.gap", label: "gap in the recording (1)" },
  ]);
});

test("where logs are mapped is told, and what keeps the cluster from it", () => {
  const idle = { none: 2, queued: 0, running: 0, done: 0, failed: 0 };
  expect(placeOf(null, 1)).toBe("On this server, 1 log at once.");
  expect(placeOf({ workers: 1, threads: 4, error: "" }, 4)).toBe("On a Dask cluster with 1 worker, 4 logs at once.");
  expect(troubleOf(null, idle)).toBeNull();
  expect(troubleOf({ workers: 1, threads: 1, error: "" }, idle)).toBeNull();
  const away = { workers: 0, threads: 0, error: "It is not reached." };
  expect(troubleOf(away, idle)).toBe("It is not reached.");
  expect(troubleOf(away, { ...idle, queued: 1 })).toContain("It is not reached. Logs that are not mapped yet wait");
  const fewer = { workers: 1, threads: 1, error: "1 of 2 workers get no logs." };
  expect(troubleOf(fewer, { ...idle, queued: 1 })).toBe("1 of 2 workers get no logs.");
});
