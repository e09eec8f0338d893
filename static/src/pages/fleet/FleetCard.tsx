import { Icon } from "../../ui/Icon";
import { ProgressBar } from "../../ui/ProgressBar";
import { LogPicture } from "../logs/library/LogPicture";
import type { Facts, Finding, FleetLog } from "./fleetLogs";

const metres = (cells: number, resolution: number): string => `${Math.max(1, Math.round(cells * resolution))}`;

/** One log: its map, or why there is none. */
export function FleetCard({ log }: { log: FleetLog }) {
  return (
    <li class={`card fleet-card ${log.state}`}>
      {log.state === "failed" ? null : <Picture log={log} />}
      <h2>
        <a href={`/logs.html?log=${encodeURIComponent(log.id)}`}>{log.name}</a>
      </h2>
      {log.facts ? <About facts={log.facts} /> : <State log={log} />}
    </li>
  );
}

function Picture({ log }: { log: FleetLog }) {
  return (
    <LogPicture id={log.id} hasPicture={log.facts?.picture ?? false} isAwaited={false} alt={`Map of ${log.name}`}>
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
