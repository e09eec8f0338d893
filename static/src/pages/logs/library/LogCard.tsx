import { useSignal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { confirm } from "../../../ui/Dialog";
import { Icon } from "../../../ui/Icon";
import { ProgressBar } from "../../../ui/ProgressBar";
import { toast } from "../../../ui/Toast";
import {
  file,
  hasClouds,
  inside,
  lidars,
  readingText,
  remedy,
  run,
  SENSOR_SEPARATOR,
  topic,
  trajectoryLabel,
  transformsOf,
} from "./describeLog";
import { LogPicture } from "./LogPicture";
import { ask, isMoving, type LogRecord, putTags, remove } from "./library";

/** The tags of a log, and a field for editing them. */
function LogTags({ log }: { readonly log: LogRecord }) {
  const isEdited = useSignal(false);
  const field = useRef<HTMLInputElement>(null);
  useLayoutEffect(() => {
    if (isEdited.value) field.current?.focus();
  }, [isEdited.value]);
  const save = async (): Promise<void> => {
    const tags = (field.current?.value ?? "").split(",").filter((tag) => tag.trim() !== "");
    const wrong = await putTags(log.id, tags);
    if (wrong) toast(wrong, "error");
    else isEdited.value = false;
  };
  if (isEdited.value) {
    return (
      <form
        class="log-tags"
        onSubmit={(event) => {
          event.preventDefault();
          void save();
        }}
      >
        <input
          ref={field}
          class="field-text tag-field"
          aria-label={`Tags of ${log.name}, with commas between them`}
          placeholder="corridor, night"
          defaultValue={log.tags.join(", ")}
          onKeyDown={(event) => {
            if (event.key === "Escape") isEdited.value = false;
          }}
        />
        <Button kind="quiet" icon="check" label="Save tags" onClick={() => void save()} />
      </form>
    );
  }
  return (
    <div class="log-tags">
      {log.tags.map((tag) => (
        <span key={tag} class="tag">
          {tag}
        </span>
      ))}
      <button
        type="button"
        class="tag add"
        aria-label={log.tags.length === 0 ? `Add a tag to ${log.name}` : `Change the tags of ${log.name}`}
        onClick={() => {
          isEdited.value = true;
        }}
      >
        {log.tags.length === 0 ? "Add a tag" : "Change"}
      </button>
    </div>
  );
}

/** Failures whose cause may not be the log, so that reading it can be tried again. */
const RETRYABLE = /\.(cancelled|interrupted|reader_died|reader_failed|storage|time)$/;

interface LogCardProps {
  readonly log: LogRecord;
  readonly onOpen: (log: LogRecord, topic: string | null, in3d?: boolean) => void;
}

/** One log: its contents or its error, and the actions on it. */
export function LogCard({ log, onOpen }: LogCardProps) {
  const moving = isMoving(log);
  const isOwn = log.source === "upload";
  // The server's own logs can be opened at any time; opening one reads it first.
  const opens = log.state === "ready" || (moving && !isOwn);
  return (
    <li class={`card log-card ${log.state}`}>
      {log.state !== "failed" && (
        <LogPicture id={log.id} hasPicture={log.has_picture && !moving} isAwaited={moving} alt="">
          {moving && isOwn && (
            <ProgressBar fraction={log.progress > 0 ? log.progress : null} label={`Reading ${log.name}`} />
          )}
        </LogPicture>
      )}
      <div class="log-head">
        <h3>{log.name}</h3>
        {isOwn && moving && (
          <Button
            kind="quiet"
            icon="close"
            label={`Stop reading ${log.name}`}
            onClick={() => void request(log, "cancel")}
          />
        )}
        {isOwn && !moving && (
          <Button kind="quiet" icon="trash" label={`Delete ${log.name}`} onClick={() => void confirmDelete(log)} />
        )}
      </div>
      {log.state === "failed" ? <Failure log={log} /> : <Facts log={log} onOpen={onOpen} />}
      {log.state === "failed" && isOwn && RETRYABLE.test(log.error?.code ?? "") && (
        <div class="actions">
          <Button icon="restart" onClick={() => void request(log, "read")}>
            Read it again
          </Button>
        </div>
      )}
      {log.state === "ready" && <LogTags log={log} />}
      {opens && (
        <div class="actions">
          <Button kind="primary" icon="map" onClick={() => onOpen(log, null)}>
            {openLabel(log)}
          </Button>
          {log.clouds === 0 && hasClouds(log) && (
            <Button icon="cube" onClick={() => onOpen(log, null, true)}>
              Open in 3D
            </Button>
          )}
        </div>
      )}
    </li>
  );
}

/** The button of a sensor other than the selected one. Screen readers read its name without the surrounding line. */
function openSensorLabel(name: string): string {
  const transforms = transformsOf(name);
  return transforms === null ? `Open ${name}` : `Open with the transforms of ${transforms}`;
}

function openLabel(log: LogRecord): string {
  if (log.map) return "Edit map";
  if (log.clouds > 0) return "Open in 3D";
  return log.costmaps > 0 ? "Open costmaps" : "Open map";
}

function Facts({ log, onOpen }: LogCardProps) {
  const known = run(log);
  const pending = log.source === "sample" ? "being simulated …" : readingText(log);
  return (
    <>
      <p class={`log-run number${known.length > 0 ? "" : " unknown"}`}>{known.join(" · ") || pending}</p>
      <p class="quiet number">{file(log).join(" · ")}</p>
      {log.trajectories.length > 1 && (
        <p
          class="quiet"
          title={log.trajectories.map((trajectory) => `${trajectory.name}: ${trajectory.description}`).join("\n")}
        >
          Trajectories: {log.trajectories.map((trajectory) => trajectoryLabel(trajectory.name)).join(", ")}
        </p>
      )}
      {known.length > 0 && <Inside log={log} onOpen={onOpen} />}
      {log.notes.length > 0 && (
        <details>
          <summary>{log.notes.length === 1 ? "1 note" : `${log.notes.length} notes`}</summary>
          <ul>
            {log.notes.map((note) => (
              <li key={note}>{note}</li>
            ))}
          </ul>
        </details>
      )}
    </>
  );
}

/** Details of the file's contents, folded. */
function Inside({ log, onOpen }: LogCardProps) {
  const lines = inside(log);
  if (lines.length === 0 && log.topics.length === 0) return null;
  const together = lidars(log);
  return (
    <details>
      <summary>Contents</summary>
      <ul>
        {lines.map((line) => (
          <li key={line}>{line}</li>
        ))}
        {log.topics.map((recorded) => (
          <li key={recorded.name} class="log-topic">
            {recorded.chosen ? <strong>{recorded.name}</strong> : recorded.name}:{" "}
            <span class="number">{topic(recorded)}</span>
            {recorded.beams !== null && !recorded.chosen && (
              <button type="button" onClick={() => onOpen(log, recorded.name)}>
                {openSensorLabel(recorded.name)}
              </button>
            )}
          </li>
        ))}
        {together.length > 1 && (
          <li class="log-topic">
            Lidars of one robot make one map:
            <button type="button" onClick={() => onOpen(log, together.join(SENSOR_SEPARATOR))}>
              Map {together.length} lidars together
            </button>
          </li>
        )}
      </ul>
    </details>
  );
}

function Failure({ log }: { log: LogRecord }) {
  const todo = remedy(log);
  return (
    <>
      <p class="quiet number">{file(log).join(" · ")}</p>
      <p class="card-error">
        <Icon name="warning" /> {log.error?.message ?? "The log could not be read."}
      </p>
      {todo && <p class="card-text">{todo}</p>}
    </>
  );
}

async function request(log: LogRecord, what: "cancel" | "read"): Promise<void> {
  const wrong = await ask(log.id, what);
  if (wrong) toast(wrong, "error");
}

async function confirmDelete(log: LogRecord): Promise<void> {
  const yes = await confirm(
    `Delete ${log.name}?`,
    "The log is removed from the server. Downloaded maps are not affected.",
    "Delete",
  );
  if (!yes) return;
  const wrong = await remove(log.id);
  toast(wrong ?? `${log.name} was deleted.`, wrong ? "error" : "note");
}
