/** The 3D view of a log: its map and poses, or its point clouds in a separate session. */

import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { useContext, useEffect, useMemo } from "preact/hooks";
import { connect } from "../../../store/connect";
import type { Store } from "../../../store/store";
import { PickingScene } from "../../../tools/scene/PickingScene";
import { LookGroup } from "../../../tools/volume/LookGroup";
import { VolumeStage } from "../../../tools/volume/VolumeStage";
import { switched } from "../../../ui/bound";
import { SwitchChip } from "../../../ui/dock/SwitchChip";
import { ask } from "../../../wire/ask";
import { exposeClouds } from "../../debugHook";
import { ContentsContext } from "../contents/useContents";
import { opening } from "../library/library";
import { Opening } from "../Opening";
import { hasClouds, type Solid } from "./solid";

/**
 * The number of a recording's clouds until the time of another map of it, assuming even intervals, because their times
 * are not known here. All of them if one of the two has no times; null until both are known.
 */
export function cloudsAt(clouds: Store, main: Store): number | null {
  const [own, other] = [clouds.hello.value?.log, main.hello.value?.log];
  const frame = main.frame.value;
  const count = clouds.hello.value?.log?.n_scans ?? 0;
  if (!own || !other || !frame || count === 0) return null;
  if (own.start_s === null || other.start_s === null || own.duration_s <= 0 || frame.index === frame.count)
    return count;
  const since = other.start_s + frame.stamp - own.start_s;
  return since < 0 ? 0 : Math.min(count, 1 + Math.floor((since / own.duration_s) * (count - 1)));
}

interface CloudsProps {
  /** The id of the log. */
  readonly log: string;
  /** Of the map whose time the clouds follow. */
  readonly main: Store;
  readonly solid: Solid;
}

export function Clouds({ log, main, solid }: CloudsProps) {
  const session = useSignal<string | null>(null);
  const failure = useSignal<string | null>(null);
  useEffect(() => {
    const ending = new AbortController();
    const opened = solid.open(ending.signal);
    opened.then(
      ({ id }) => {
        session.value = id;
      },
      (error: Error) => {
        if (!ending.signal.aborted) failure.value = error.message;
      },
    );
    return () => {
      ending.abort();
      const end = ({ id }: { readonly id: string }) =>
        ask("DELETE /api/sessions/{session_id}", { session_id: id }).catch(() => undefined); // it ends by itself later
      void opened.then(end, () => undefined);
    };
  }, [log]);
  if (failure.value) return <p role="alert">{failure.value}</p>;
  return session.value ? (
    <CloudStage session={session.value} main={main} solid={solid} />
  ) : (
    <div class="clouds-place">
      <Opening now={opening.value} what="Opening the log" />
    </div>
  );
}

interface CloudStageProps extends Omit<CloudsProps, "log"> {
  readonly session: string;
}

function CloudStage({ session, main, solid }: CloudStageProps) {
  const connection = useMemo(() => connect(session), [session]);
  const { store, trouble } = connection;
  useEffect(() => {
    const stop = solid.beginClouds({ session, store });
    exposeClouds(connection);
    connection.start();
    return () => {
      connection.stop();
      stop();
    };
  }, [connection]);
  const scan = useComputed(() => cloudsAt(store, main));
  useSignalEffect(() => {
    const index = scan.value;
    if (index === null) return;
    store.send({ type: "pause" });
    store.sendSoon({ type: "seek", index });
  });
  return (
    <>
      <div class="clouds-place">
        <VolumeStage session={session} store={store} />
        {trouble.value && (
          <p class="viewer-over" role="status">
            {trouble.value}
          </p>
        )}
      </div>
      <details class="clouds-look">
        <summary>Colours and clip box</summary>
        <LookGroup store={store} />
      </details>
    </>
  );
}

interface SolidViewProps {
  readonly store: Store;
  readonly session: string;
  readonly solid: Solid;
}

export function SolidView({ store, session, solid }: SolidViewProps) {
  const contents = useContext(ContentsContext)?.state.value;
  const log = store.hello.value?.log?.id;
  if (!log || !contents || !(solid.clouds.value || hasClouds(contents))) {
    return <PickingScene store={store} session={session} />;
  }
  return (
    <>
      <div class="actions">
        <SwitchChip
          label="Point clouds"
          title="The point clouds of the log as voxels or points, at the time of the map."
          {...switched(solid.clouds)}
        />
      </div>
      {solid.clouds.value ? (
        <Clouds log={log} main={store} solid={solid} />
      ) : (
        <PickingScene store={store} session={session} />
      )}
    </>
  );
}
