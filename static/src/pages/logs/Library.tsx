import { useEffect } from "preact/hooks";
import { Button } from "../../ui/Button";
import { confirm } from "../../ui/Dialog";
import { Dropzone } from "../../ui/Dropzone";
import { Icon } from "../../ui/Icon";
import { bytes, clock } from "../../ui/numbers";
import { toast } from "../../ui/Toast";
import { dismiss, type LogRecord, listError, logs, refresh, remove, type Upload, upload, uploads } from "./library";

const SOURCES: Record<LogRecord["source"], string> = {
  sample: "sample",
  folder: "this server's",
  upload: "yours",
};

/** Every log there is, and the place to drop one's own. */
export function Library({ onOpen }: { onOpen: (log: LogRecord) => void }) {
  useEffect(() => {
    void refresh();
  }, []);
  const order: readonly LogRecord["source"][] = ["upload", "sample", "folder"];
  const list = logs.value?.toSorted((a, b) => order.indexOf(a.source) - order.indexOf(b.source)) ?? null;
  return (
    <div class="library">
      <div class="library-head">
        <h1>Robot logs</h1>
        <p class="prose">
          Choose a run and watch the map it makes fill in. Then change a parameter: the whole map is made anew, from
          every reading of the log, while the slider moves.
        </p>
      </div>
      <Dropzone button="Choose a log" onFiles={(files) => files.forEach(upload)}>
        <p>
          <strong>Drop your own log here</strong>
        </p>
        <p class="quiet">CARMEN, plain or gzipped. Only this browser will see it.</p>
      </Dropzone>
      {uploads.value.map((one) => (
        <UploadCard key={one.key} upload={one} />
      ))}
      {listError.value && (
        <p class="notice" role="alert">
          <Icon name="warning" /> {listError.value}
        </p>
      )}
      {list === null && !listError.value && (
        <div class="cards" aria-busy="true">
          <div class="card ghost" />
          <div class="card ghost" />
          <div class="card ghost" />
        </div>
      )}
      {list?.length === 0 && <p class="notice">There are no logs here yet. Drop one above to see its map.</p>}
      {list && list.length > 0 && (
        <ul class="cards">
          {list.map((log) => (
            <LogCard key={log.id} log={log} onOpen={onOpen} />
          ))}
        </ul>
      )}
    </div>
  );
}

function UploadCard({ upload: one }: { upload: Upload }) {
  const part = one.bytes > 0 ? one.sent / one.bytes : 0;
  return (
    <div class={`upload${one.error ? " failed" : ""}`} role={one.error ? "alert" : "status"}>
      <Icon name={one.error ? "warning" : "upload"} />
      <div class="upload-text">
        <strong>{one.name}</strong>
        {one.error ? (
          <p>{one.error}</p>
        ) : (
          <>
            <p class="quiet number">
              {bytes(one.sent)} of {bytes(one.bytes)}
            </p>
            <div class="progress">
              <span style={{ transform: `scaleX(${part})` }} />
            </div>
          </>
        )}
      </div>
      {one.error && <Button kind="quiet" icon="close" label="Dismiss" onClick={() => dismiss(one.key)} />}
    </div>
  );
}

function facts(log: LogRecord): readonly string[] {
  const found = [bytes(log.bytes)];
  if (log.scans !== null) found.unshift(`${log.scans.toLocaleString("en")} scans`);
  if (log.beams !== null) found.splice(1, 0, `${log.beams} beams`);
  if (log.duration_s !== null && log.duration_s > 0) found.splice(2, 0, `${clock(log.duration_s)} long`);
  if (log.format) found.push(log.format);
  return log.bytes > 0 ? found : found.filter((fact) => fact !== bytes(0));
}

function LogCard({ log, onOpen }: { log: LogRecord; onOpen: (log: LogRecord) => void }) {
  const moving = log.state === "queued" || log.state === "reading";
  const erase = async (): Promise<void> => {
    const yes = await confirm(
      `Delete ${log.name}?`,
      "The log is removed from the server. Maps that you downloaded stay yours.",
      "Delete",
    );
    if (!yes) return;
    const wrong = await remove(log.id);
    toast(wrong ?? `${log.name} is deleted.`, wrong ? "error" : "note");
  };
  return (
    <li class={`card log-card ${log.state}`}>
      <div class="log-name">
        <h3>{log.name}</h3>
        <span class="tag">{SOURCES[log.source]}</span>
      </div>
      <p class="quiet number">{facts(log).join(" · ")}</p>
      {log.trajectories.length > 1 && (
        <p class="quiet">
          {log.trajectories.length} trajectories: {log.trajectories.map((one) => one.name).join(", ")}
        </p>
      )}
      {log.state === "failed" && (
        <p class="log-error">
          <Icon name="warning" /> {log.error?.message ?? "The log could not be read."}
        </p>
      )}
      {log.notes.length > 0 && log.state !== "failed" && (
        <details class="log-notes">
          <summary>{log.notes.length === 1 ? "1 note" : `${log.notes.length} notes`}</summary>
          <ul>
            {log.notes.map((note) => (
              <li key={note}>{note}</li>
            ))}
          </ul>
        </details>
      )}
      {moving && (
        <div
          class={`progress${log.progress > 0 ? "" : " waiting"}`}
          role="progressbar"
          aria-label={`Reading ${log.name}`}
        >
          <span {...(log.progress > 0 ? { style: { transform: `scaleX(${log.progress})` } } : {})} />
        </div>
      )}
      <div class="log-actions">
        {log.state === "ready" && (
          <Button kind="primary" icon="map" onClick={() => onOpen(log)}>
            Make its map
          </Button>
        )}
        {moving && <span class="quiet">{log.state === "queued" ? "waiting its turn …" : "being read …"}</span>}
        {log.source === "upload" && !moving && (
          <Button kind="quiet" icon="trash" label={`Delete ${log.name}`} onClick={() => void erase()} />
        )}
      </div>
    </li>
  );
}
