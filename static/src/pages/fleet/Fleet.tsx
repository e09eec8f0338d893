import { useSignal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { Icon } from "../../ui/Icon";
import { plural } from "../../ui/numbers";
import { ProgressBar } from "../../ui/ProgressBar";
import { toast } from "../../ui/Toast";
import { ask } from "../../wire/ask";
import { run } from "../logs/library/describeLog";
import { LogPicture } from "../logs/library/LogPicture";
import type { LogRecord } from "../logs/library/library";
import { FleetOptions } from "./FleetOptions";
import {
  type Counts,
  chosen,
  cluster,
  counts,
  DRIFTS,
  EVERY,
  type Facts,
  type Finding,
  type FleetLog,
  firstFindings,
  fleetError,
  fleetLogs,
  isBusy,
  mapAll,
  ORDERS,
  type Order,
  placeOf,
  SHOWN,
  stopMapping,
  totalOf,
  troubleOf,
  type Wanted,
  watchFleet,
  workers,
} from "./fleetLogs";

const SAMPLE = "sample-office";
/** Interval of the requests that ask whether the sample is ready. */
const AGAIN_MS = 1000;

/** Shown while there are no logs: what the page does, with the sample as an example of its cards. */
function FleetStart() {
  return (
    <section class="fleet-start" aria-label="Without logs">
      <div class="fleet-start-text">
        <p>
          <strong>There are no logs with scans here yet.</strong> Once there are, one press maps all of them, and each
          gets a card with
        </p>
        <ul>
          <li>its map, its number of scans and the size of the map,</li>
          <li>the drift in metres and the sharpness of the map, by which the cards can be ordered,</li>
          <li>what the doctor found in it, or why it could not be read.</li>
        </ul>
        <div class="actions">
          <Button kind="primary" icon="upload" href="/logs.html">
            Add logs
          </Button>
        </div>
        <p class="quiet">
          A folder of this machine: <code>gridbloom serve --logs-dir FOLDER</code>. Without pages:{" "}
          <code>gridbloom fleet LOGS --out FOLDER</code>.
        </p>
      </div>
      <Example />
    </section>
  );
}

function Example() {
  const sample = useSignal<LogRecord | null>(null);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isGone = false;
    const look = async (): Promise<void> => {
      // without an answer the page says so above
      sample.value = await ask("GET /api/logs/{log_id}", { log_id: SAMPLE }).catch(() => null);
      if (!isGone && !sample.value?.has_picture) timer = setTimeout(() => void look(), AGAIN_MS);
    };
    void look();
    return () => {
      isGone = true;
      clearTimeout(timer);
    };
  }, []);
  const log = sample.value;
  return (
    <div class="fleet-example">
      <p class="quiet">An example</p>
      <div class="card fleet-card">
        <LogPicture
          id={SAMPLE}
          hasPicture={log?.has_picture ?? false}
          isAwaited={!log?.has_picture}
          alt="Map of the sample"
        />
        <h2>
          <a href={`/logs.html?log=${SAMPLE}`}>{log?.name ?? "Sample"}</a>
        </h2>
        <p class="quiet number">{log ? run(log).join(", ") : ""}</p>
      </div>
    </div>
  );
}

const metres = (cells: number, resolution: number): string => `${Math.max(1, Math.round(cells * resolution))}`;

/** One log: its map, or the reason why it has none. */
function FleetCard({ log }: { log: FleetLog }) {
  return (
    <li class={`card fleet-card ${log.state}`}>
      {log.state === "failed" ? null : <Picture log={log} />}
      <h2>
        <a href={`/logs.html?log=${encodeURIComponent(log.id)}`}>{log.name}</a>
      </h2>
      {log.facts ? <About facts={log.facts} /> : <State log={log} />}
      {log.options && <p class="quiet fleet-with">With {log.options}</p>}
    </li>
  );
}

function Picture({ log }: { log: FleetLog }) {
  return (
    <LogPicture
      key={log.state}
      id={log.id}
      hasPicture={log.has_picture && log.state !== "running"}
      isAwaited={false}
      alt={`Map of ${log.name}`}
    >
      {log.state === "running" && (
        <ProgressBar fraction={log.fraction > 0 ? log.fraction : null} label={`Mapping ${log.name}`} />
      )}
    </LogPicture>
  );
}

function About({ facts }: { facts: Facts }) {
  const { rows, cols, resolution, findings } = facts;
  const [first, ...others] = findings;
  return (
    <>
      <p class="quiet number">
        <strong>{facts.drift_m === null ? "Drift not measured" : `Drift ${facts.drift_m.toFixed(2)} m`}</strong>
        {facts.contrast !== null && (
          <>
            , <span class="fleet-measure">sharpness {facts.contrast.toFixed(2)}</span>
          </>
        )}
      </p>
      <p class="quiet number">
        {facts.scans.toLocaleString("en")} scans, {metres(cols, resolution)} × {metres(rows, resolution)} m
      </p>
      {first ? (
        <details>
          <summary>
            <span class="fleet-finding">{sentenceOf(first)}</span>
            {others.length > 0 && <span class="quiet">and {others.length} more</span>}
          </summary>
          <ul>
            {others.map((other) => (
              <li key={other.check + other.sentence}>{sentenceOf(other)}</li>
            ))}
          </ul>
        </details>
      ) : (
        <p class="quiet">No findings</p>
      )}
    </>
  );
}

const sentenceOf = ({ possible, sentence }: Finding): string => (possible ? `Possibly: ${sentence}` : sentence);

const STATES = { none: "Not mapped yet", queued: "Waiting", running: "Being mapped", done: "", failed: "" } as const;

function State({ log }: { log: FleetLog }) {
  if (log.error) {
    return (
      <p class="card-error">
        <Icon name="warning" /> <span>{log.error.message}</span>
      </p>
    );
  }
  return <p class="quiet">{STATES[log.state]}</p>;
}

/** Number of cards shown at first and added by each press of "Show more". */
const PAGE = 120;

const quietly = (work: Promise<void>): void => {
  work.catch((error: Error) => toast(error.message));
};

/** All logs, each read, examined and mapped once, as a grid of maps. */
export function Fleet() {
  useEffect(watchFleet, []);
  const [wanted, setWanted] = useState(EVERY);
  const [order, setOrder] = useState<Order>("name");
  const [limit, setLimit] = useState(PAGE);
  const logs = fleetLogs.value;
  const all = counts.value;
  const trouble = troubleOf(cluster.value, all);
  const matching = logs === null ? [] : chosen(logs.values(), wanted, order);
  const findings = firstFindings(logs?.values() ?? []);
  const want = (change: Partial<Wanted>): void => {
    setWanted({ ...wanted, ...change });
    setLimit(PAGE);
  };
  return (
    <div class="library fleet">
      <div class="page-head">
        <h1>Map all logs</h1>
        <p class="prose">
          Each of your logs and of those on this server is read, examined and mapped once. Press a map to open its log.
        </p>
      </div>
      {fleetError.value && (
        <p class="notice" role="alert">
          <Icon name="warning" /> {fleetError.value}
        </p>
      )}
      {logs !== null && totalOf(all) === 0 && <FleetStart />}
      {logs !== null && totalOf(all) > 0 && (
        <>
          {trouble !== null && (
            <p class="notice" role="status">
              <Icon name="warning" /> {trouble}
            </p>
          )}
          <Work all={all} />
          <search class="finder">
            <input
              class="field-text finder-words"
              type="search"
              placeholder="Search name, finding, reason"
              aria-label="Search logs"
              onInput={(event) => want({ words: event.currentTarget.value })}
            />
            <Choice
              label="Which logs"
              bare
              options={SHOWN}
              value={wanted.shown}
              onChange={(value) => want({ shown: value })}
            />
            <Choice
              label="Drift"
              bare
              options={DRIFTS}
              value={String(wanted.drift)}
              onChange={(value) => want({ drift: Number(value) })}
            />
            {findings.length > 1 && (
              <Choice
                label="First finding"
                bare
                options={findings}
                value={wanted.finding}
                onChange={(value) => want({ finding: value })}
              />
            )}
            <Choice label="Order" bare options={ORDERS} value={order} onChange={(value) => setOrder(value)} />
            <span class="quiet number" role="status">
              {matching.length < totalOf(all) ? `${plural(matching.length, "log")} found` : ""}
            </span>
          </search>
          <ul class="cards">
            {matching.slice(0, limit).map((log) => (
              <FleetCard key={log.id} log={log} />
            ))}
          </ul>
          {matching.length > limit && (
            <div class="library-more">
              <Button onClick={() => setLimit(limit + PAGE)}>Show more</Button>
              <span class="quiet number">
                {limit} of {plural(matching.length, "log")}
              </span>
            </div>
          )}
        </>
      )}
    </div>
  );
}

/** Progress, and the possible actions. */
function Work({ all }: { all: Counts }) {
  const total = totalOf(all);
  const ended = all.done + all.failed;
  const busy = isBusy(all);
  return (
    <section class="fleet-work stack" aria-label="Progress">
      <p>
        <strong class="number">
          {ended.toLocaleString("en")} of {plural(total, "log")}
        </strong>{" "}
        done
        {all.failed > 0 && <>, {all.failed.toLocaleString("en")} failed</>}
        {busy && <>, {all.running} being mapped</>}
      </p>
      <ProgressBar fraction={ended / Math.max(1, total)} label="Logs done" />
      <p class="quiet number">{placeOf(cluster.value, workers.value)}</p>
      <div class="actions">
        {!busy && all.none > 0 && (
          <Button kind="primary" icon="play" onClick={() => quietly(mapAll(false))}>
            {ended > 0 ? `Map the other ${all.none.toLocaleString("en")}` : `Map ${plural(all.none, "log")}`}
          </Button>
        )}
        {busy && (
          <Button icon="close" onClick={() => quietly(stopMapping())}>
            Stop
          </Button>
        )}
        {!busy && all.failed > 0 && (
          <Button icon="restart" onClick={() => quietly(mapAll(true))}>
            Try those that failed again
          </Button>
        )}
        <a class="button quiet" href="/logs.html">
          All logs
        </a>
      </div>
      <FleetOptions isBusy={busy} onMap={(options) => quietly(mapAll(false, options))} />
    </section>
  );
}
