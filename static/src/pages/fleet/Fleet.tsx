import { useEffect, useState } from "preact/hooks";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { Icon } from "../../ui/Icon";
import { plural } from "../../ui/numbers";
import { ProgressBar } from "../../ui/ProgressBar";
import { toast } from "../../ui/Toast";
import { FleetCard } from "./FleetCard";
import { FleetStart } from "./FleetStart";
import {
  type Counts,
  chosen,
  cluster,
  counts,
  DRIFTS,
  EVERY,
  firstFindings,
  fleetError,
  fleetLogs,
  isBusy,
  mapAll,
  ORDERS,
  type Order,
  placeOf,
  SHOWN,
  type Shown,
  stopMapping,
  totalOf,
  troubleOf,
  type Wanted,
  watchFleet,
  workers,
} from "./fleetLogs";

/** Cards that are shown at first, and with each press of "Show more". */
const PAGE = 120;

const quietly = (work: Promise<void>): void => {
  work.catch((error: Error) => toast(error.message));
};

/** All logs, each read, examined and mapped once, and a wall of their maps. */
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
              onChange={(value) => want({ shown: value as Shown })}
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
            <Choice label="Order" bare options={ORDERS} value={order} onChange={(value) => setOrder(value as Order)} />
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

/** How far it is, and what can be done. */
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
    </section>
  );
}
