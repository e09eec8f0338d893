/** The point clouds of a log as a map in 3D, beside the map of its scans: a session that ends with the view. */

import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { connect } from "../../../store/connect";
import type { Store } from "../../../store/store";
import { VolumeStage } from "../../../tools/volume/VolumeStage";
import { ask } from "../../../wire/ask";
import { openSession } from "../library/library";
import { Opening } from "../Opening";
import { cloudsAt } from "./cloudsAt";

interface CloudsProps {
  /** The id of the log. */
  readonly log: string;
  /** Of the map whose time the clouds follow. */
  readonly main: Store;
}

export function Clouds({ log, main }: CloudsProps) {
  const session = useSignal<string | null>(null);
  const failure = useSignal<string | null>(null);
  useEffect(() => {
    const ending = new AbortController();
    const opened = openSession(log, null, ending.signal, { other: null, up: null });
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
  return (
    <div class="clouds-place">{session.value ? <CloudStage session={session.value} main={main} /> : <Opening />}</div>
  );
}

function CloudStage({ session, main }: { readonly session: string; readonly main: Store }) {
  const connection = useMemo(() => connect(session), [session]);
  useEffect(() => {
    connection.start();
    return () => connection.stop();
  }, [connection]);
  const { store, trouble } = connection;
  const wanted = useComputed(() => cloudsAt(store, main));
  useSignalEffect(() => {
    const index = wanted.value;
    if (index === null) return;
    store.send({ type: "pause" });
    store.sendSoon({ type: "seek", index });
  });
  return (
    <>
      <VolumeStage session={session} store={store} />
      {trouble.value && (
        <p class="viewer-over" role="status">
          {trouble.value}
        </p>
      )}
    </>
  );
}
