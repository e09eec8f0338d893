import "../style/index.css";
import "./logs/library/library.css";
import "./logs/viewer.css";
import { signal } from "@preact/signals";
import { followedCode } from "../store/classroom";
import { ShowsOther } from "../tools/classroom/pages";
import { lazy } from "../ui/lazy";
import { LAYOUT } from "../ui/stage/useLayout";
import { mayPass, whyAgain } from "../wire/ask";
import type { NewVolume } from "../wire/http";
import { ClassLog, followLogs } from "./logs/ClassLog";
import { CostmapViewer } from "./logs/costmaps/CostmapViewer";
import { Library } from "./logs/library/Library";
import { type LogRecord, opening, openSession } from "./logs/library/library";
import { MapEditor } from "./logs/mapediting/MapEditor";
import { Opening } from "./logs/Opening";
import { Guest } from "./logs/share/Guest";
import { linkOf } from "./logs/share/links";
import { Viewer } from "./logs/Viewer";
import { renderPage } from "./renderPage";
import { NotOpened } from "./SessionEnded";

const VolumeViewer = lazy(async () => (await import("./logs/volume/VolumeViewer")).VolumeViewer);

type Up = Required<NewVolume>["up"];

/**
 * The query of the address, `?log=ID&topic=NAME&session=ID&kind=KIND`. The topic is one of the log's sensors; null is
 * the default. The kind is that of the session; null is that of a log.
 */
interface Place {
  readonly log: string | null;
  readonly topic: string | null;
  readonly session: string | null;
  readonly kind?: string | null;
  /** Whether the log is opened in 3D; the log to compare it with, or "". */
  readonly volume?: string | null;
  /** The axis of the file that points up in 3D; null for the server's guess. */
  readonly up?: Up;
}

function placeOf(search: string): Place {
  const query = new URLSearchParams(search);
  return {
    log: query.get("log"),
    topic: query.get("topic"),
    session: query.get("session"),
    kind: query.get("kind"),
    volume: query.get("volume"),
    up: query.get("up") as Up, // the server refuses any other
  };
}

/** The token of the shared link that this page was opened with, or null. */
const link = linkOf(location.pathname);
const place = signal<Place>(placeOf(location.search));
const failure = signal<string | null>(null);

/** Delay before the next request to a server that did not answer. */
const RETRY_MS = 3000;

function go({ log, topic, session, kind = null, volume = null, up = null }: Place, replace = false): void {
  const query = new URLSearchParams();
  if (log) query.set("log", log);
  if (topic) query.set("topic", topic);
  if (session) query.set("session", session);
  if (volume !== null) query.set("volume", volume);
  if (volume !== null && up !== null) query.set("up", up);
  if (session && kind) query.set("kind", kind);
  // The layout of the views belongs to the log that the address names.
  const views = replace ? new URLSearchParams(location.search).get(LAYOUT) : null;
  if (views) query.set(LAYOUT, views);
  // When the entry is replaced, the fragment stays: it may describe a comparison.
  const address = (query.size > 0 ? `?${query}` : location.pathname) + (replace ? location.hash : "");
  if (replace) history.replaceState(null, "", address);
  else history.pushState(null, "", address);
  place.value = { log, topic, session, kind, volume, up };
  if (!log && !session) document.title = "Logs · Gridbloom";
}

/** Aborts the request for the session that is being opened. */
let ending: AbortController | null = null;

function cancelOpening(): void {
  ending?.abort();
  close();
}

/** Open a session on a log; with `replace` the session is added to the current address. */
async function open(
  log: string,
  topic: string | null,
  replace: boolean,
  volume: string | null = null,
  up: Up = null,
): Promise<void> {
  go({ log, topic, session: null, volume, up }, replace);
  ending?.abort();
  const own = new AbortController();
  ending = own;
  try {
    const session = await openSession(log, topic, own.signal, volume === null ? null : { other: volume || null, up });
    failure.value = null;
    const now = place.peek();
    if (now.log !== log || now.topic !== topic || (now.volume ?? null) !== volume || (now.up ?? null) !== up) return;
    const kind = session.kind === "log" ? null : session.kind;
    // A file without planar scans is opened in 3D even if the address does not request it.
    go({ log, topic, session: session.id, kind, volume: kind === "volume" ? (volume ?? "") : volume, up }, true);
  } catch (error) {
    if (own.signal.aborted) return;
    const isRepeated = mayPass(error);
    failure.value = isRepeated ? whyAgain(error) : (error as Error).message;
    if (isRepeated) setTimeout(resume, RETRY_MS);
  }
}

addEventListener("popstate", () => {
  ending?.abort();
  failure.value = null;
  place.value = placeOf(location.search);
  resume();
});

function resume(): void {
  const { log, topic, session, volume, up } = place.peek();
  if (log && !session) void open(log, topic, true, volume ?? null, up ?? null);
}

/** Open a log of the list, in 3D if it has no planar scans or if that is requested. */
function openChosen(chosen: LogRecord, sensor: string | null, in3d = false): void {
  void open(chosen.id, sensor, false, in3d || chosen.clouds > 0 ? "" : null);
}

const close = (): void => go({ log: null, topic: null, session: null });

function Page() {
  if (link) return <Guest token={link} />;
  const { log, topic, session, kind, volume = null, up = null } = place.value;
  const again = (): void => (log ? void open(log, topic, true, volume, up) : close());
  if (session && kind === "volume") {
    return (
      <VolumeViewer
        key={session}
        session={session}
        log={log}
        onClose={close}
        onGone={again}
        onCompare={(other) => log && void open(log, topic, false, other ?? "", up)}
        onUp={log ? (axis) => void open(log, topic, false, volume ?? "", axis) : null}
      />
    );
  }
  if (session && (kind === "costmaps" || kind === "map")) {
    const Kind = kind === "map" ? MapEditor : CostmapViewer;
    return (
      <Kind
        key={session}
        session={session}
        onClose={close}
        onGone={() => (log ? void open(log, topic, true) : close())}
      />
    );
  }
  if (session) {
    return (
      <Viewer
        key={session}
        session={session}
        onClose={close}
        onGone={() => (log ? void open(log, topic, true) : close())}
        reopens={log !== null}
        onSensor={(chosen) => go({ log, topic: log && chosen, session }, true)}
      />
    );
  }
  if (!log) return <Library onOpen={openChosen} />;
  if (failure.value !== null && opening.value === null) {
    return (
      <NotOpened
        title="This log was not opened"
        reason={failure.value}
        onAgain={again}
        back="All logs"
        onBack={close}
      />
    );
  }
  return <Opening now={opening.value} what="Opening the log" onCancel={cancelOpening} />;
}

/** The page of a lecturer or of a visitor without a class. Followers see only the maps of logs. */
function Own() {
  const { session, kind } = place.value;
  const isMapOfLog = link === null && session !== null && !kind;
  return (
    <>
      <Page />
      {!isMapOfLog && <ShowsOther />}
    </>
  );
}

if (followedCode === null) resume();
else followLogs();
renderPage(followedCode === null ? <Own /> : <ClassLog />, { current: "logs", links: followedCode === null });
