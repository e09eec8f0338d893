import { computed, useSignal, useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Picture } from "../../render/picture/Picture";
import { framed, type SharedView } from "../../render/view";
import { type Connection, connect } from "../../store/connect";
import type { Store } from "../../store/store";
import { CompareReadout } from "../../tools/compare/Readout";
import { ParameterPanel } from "../../tools/parameters/ParameterPanel";
import { BeliefView } from "../../tools/picture/BeliefView";
import { Profile } from "../../tools/profile/Profile";
import { profileReading } from "../../tools/profile/reading";
import { Readout } from "../../tools/readout/Readout";
import { Why } from "../../tools/why/Why";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { Icon } from "../../ui/Icon";
import { MapFiles } from "../../ui/MapFiles";
import { written } from "../../ui/numbers";
import { Panel } from "../../ui/Panel";
import { reducedMotion } from "../../ui/reducedMotion";
import { toast } from "../../ui/Toast";
import { Working } from "../../ui/Working";
import { exposeHook } from "../debugHook";
import { Compare } from "./compare/Compare";
import { BothMaps, useComparison } from "./compare/useComparison";
import { Doctor } from "./Doctor";
import { sentence, trajectoryLabel } from "./describeLog";
import { Share } from "./Share";
import { Transport } from "./Transport";

interface ViewerProps {
  readonly session: string;
  /** Back to the logs; not for a guest. */
  readonly onClose?: () => void;
  /** The session has ended on the server: begin another on the same log. */
  readonly onGone: () => void;
  /** Whether to do so at once. */
  readonly reopens?: boolean;
  /** For a visitor with a shared link: the initial view, and a callback for the end of the session. */
  readonly guest?: { readonly view: SharedView | null; readonly onEnded: () => void };
}

/** The view of one log: its map, playback, parameters, downloads. */
export function Viewer({ session, onClose, onGone, reopens = false, guest }: ViewerProps) {
  const connection = useMemo(() => connect(session), [session]);
  const picture = useRef<Picture | null>(null);
  useEffect(() => {
    exposeHook(connection, () => picture.current);
    connection.start();
    return () => connection.stop();
  }, [connection]);
  const { store, status, trouble } = connection;
  const comparison = useComparison(session, store);
  useSignalEffect(() => {
    if (status.value !== "gone" || !reopens) return;
    toast("The session had ended on the server. The log was opened again with default parameters.");
    onGone();
  });
  useSignalEffect(() => {
    const notice = store.notice.value;
    // The end of the log is visible without a message.
    if (notice && notice.code !== "log.end") toast(notice.message, notice.kind);
  });
  // With reduced motion the whole map is shown at once; the timeline and the steps go through it.
  const isWhole = useRef(!reducedMotion.peek());
  useSignalEffect(() => {
    const frame = store.frame.value;
    if (isWhole.current || !frame) return;
    isWhole.current = true;
    if (frame.index === 0 && !frame.playing) store.send({ type: "seek", index: frame.count });
  });
  const hello = store.hello.value;
  useEffect(() => {
    if (hello) document.title = `${hello.title} · Gridbloom`;
  }, [hello]);

  useEffect(() => applySharedView(store, picture, guest?.view ?? null), [connection]);
  const ended = status.value === "gone";
  useEffect(() => {
    if (ended) guest?.onEnded();
  }, [ended]);

  if (ended) {
    return (
      <div class="viewer-message" role="alert">
        <h1>This session has ended</h1>
        <p class="prose">The server ends sessions that are idle. The log is still there.</p>
        <div class="actions">
          <Button kind="primary" icon="restart" onClick={onGone}>
            Open the log again
          </Button>
          {onClose && <Button onClick={onClose}>All logs</Button>}
        </div>
      </div>
    );
  }
  return (
    <div class={comparison.isOn.value ? "viewer comparing" : "viewer"}>
      <Head connection={connection} session={session} onClose={onClose} picture={picture} />
      <div class="viewer-map">
        <BeliefView
          store={store}
          comparison={comparison}
          onPicture={(made) => {
            picture.current = made;
          }}
        />
        <BothMaps store={store} comparison={comparison} />
        {!hello && !trouble.value && (
          <p class="viewer-over" role="status">
            Opening the log …
          </p>
        )}
        {trouble.value && (
          <p class="viewer-over" role="status">
            <Icon name="warning" /> {trouble.value}
          </p>
        )}
      </div>
      <Working what="Computing the map" work={store.working.value} />
      <Transport store={store} />
      <div class="viewer-readout">
        {comparison.isOn.value ? (
          <CompareReadout store={store} summedOver={comparison.summedOver.value} />
        ) : (
          <Readout store={store} />
        )}
      </div>
      <Compare store={store} session={session} comparison={comparison} isGuest={guest !== undefined} />
      <div class="viewer-column">
        <Side store={store} session={session} isGuest={guest !== undefined} />
        <Why store={store} side="right" />
      </div>
      <ProfileBox store={store} />
    </div>
  );
}

/** Show the shared part of the map as soon as the picture has a size. */
function applySharedView(store: Store, picture: RefObject<Picture | null>, view: SharedView | null): () => void {
  let waiting = 0;
  const wait = (): void => {
    const size = picture.current?.size;
    if (view && size && size.width > 0) store.setView(framed(view, size));
    else if (view) waiting = requestAnimationFrame(wait);
  };
  wait();
  return () => cancelAnimationFrame(waiting);
}

interface HeadProps {
  readonly connection: Connection;
  readonly session: string;
  readonly onClose: (() => void) | undefined;
  readonly picture: RefObject<Picture | null>;
}

function Head({ connection, session, onClose, picture }: HeadProps) {
  const { store } = connection;
  const hello = store.hello.value;
  /** The visitor's view, if they moved it: otherwise the link shows everything on any screen. */
  const sharedView = (): SharedView | null => {
    const view = store.view.peek();
    const size = picture.current?.size;
    return store.viewHeld.peek() && view && size ? { ...view, width: size.width, height: size.height } : null;
  };
  return (
    <header class="viewer-head">
      {onClose && <Button kind="quiet" icon="back" label="All logs" onClick={onClose} />}
      <h1>{hello?.title ?? "…"}</h1>
      <RecomputeTime store={store} />
      {onClose ? (
        <>
          <Button icon="cube" label="3D view" href={`/3d?session=${encodeURIComponent(session)}`}>
            <span class="button-text">3D</span>
          </Button>
          {hello?.log && <Share session={session} log={hello.log.id} sharedView={sharedView} />}
        </>
      ) : (
        <span class="guest-note">Shared view: your changes are not seen by others.</span>
      )}
    </header>
  );
}

/** Time that the server took to compute the whole map again. */
function RecomputeTime({ store }: { store: Store }) {
  const last = useSignal<{ ms: number; scans: number } | null>(null);
  useSignalEffect(() => {
    const frame = store.frame.value;
    if (frame?.remade_ms !== undefined) last.value = { ms: frame.remade_ms, scans: frame.index };
  });
  if (!last.value) return null;
  const { ms, scans } = last.value;
  return (
    <output class="viewer-badge" data-remade={ms}>
      {scans} scans re-mapped in {ms < 10 ? written(ms, 1) : Math.round(ms)} ms
    </output>
  );
}

/** Downloads of the log for visitors who may open it. */
const RUN_FILES = ["run.mcap", "trajectory.tum"];
const LABELS: Readonly<Record<string, string>> = { "trajectory.tum": "Trajectory (TUM)" };

function Side({ store, session, isGuest }: { store: Store; session: string; isGuest: boolean }) {
  const hello = store.hello.value;
  const picked = useSignal<string | null>(null);
  useSignalEffect(() => {
    // The server has accepted or refused the choice, or someone else has made another one.
    void store.trajectory.value;
    void store.notice.value;
    picked.value = null;
  });
  if (!hello) return <aside class="viewer-side" />;
  const of = (name: string): string => `/api/sessions/${encodeURIComponent(session)}/${name}`;
  const trajectories = hello.log?.trajectories ?? [];
  const trajectory = picked.value ?? store.trajectory.value?.name ?? hello.log?.trajectory ?? "";
  const chosen = trajectories.find((one) => one.name === trajectory);
  return (
    <aside class="viewer-side" aria-label="Settings">
      {trajectories.length > 1 && (
        <Panel title="Trajectory">
          <Choice
            label="Poses from"
            options={trajectories.map((one) => ({ value: one.name, label: trajectoryLabel(one.name) }))}
            value={trajectory}
            onChange={(name) => {
              picked.value = name;
              store.send({ type: "trajectory", name });
            }}
          />
          {chosen?.description && <p class="quiet">{sentence(chosen.description)}</p>}
        </Panel>
      )}
      <Doctor store={store} session={session} isGuest={isGuest} />
      <ParameterPanel
        table={hello.parameters.table}
        values={store.mapping.values}
        set={(name, value) => store.setParameter(name, value)}
      />
      <Panel title="Download">
        <div class="downloads">
          <MapFiles session={session} />
          {(isGuest ? [] : RUN_FILES).map((name) => (
            <Button key={name} icon="download" href={of(name)} download>
              {LABELS[name] ?? name.split(".").at(-1)}
            </Button>
          ))}
        </div>
        <p class="quiet">
          pgm and yaml together are a map for map_server and Nav2; both show the map at the moment of the first
          download. png is an image of the map.
          {!isGuest &&
            " mcap contains the scans, the poses and this map for Rerun and ROS 2, and for Foxglove and Lichtblick, where the topics /map, /scan and /pose are enabled in the 3D panel."}
        </p>
      </Panel>
    </aside>
  );
}

function ProfileBox({ store }: { store: Store }) {
  const reading = useMemo(() => computed(() => profileReading(store)), [store]);
  const set = useMemo(() => (name: string, value: number) => store.setParameter(name, value), [store]);
  const pointed = store.probe.value !== null;
  return (
    <section class="viewer-profile" aria-label="Inverse sensor model">
      <Profile
        parameters={store.mapping.values}
        setParameter={set}
        reading={reading}
        beamName={pointed ? "the beam towards the pointer" : "the beam straight ahead"}
      />
    </section>
  );
}
