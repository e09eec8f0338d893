import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { ask } from "../../../wire/ask";
import { followMaking, type Making, newName } from "../../making";

/** The cut of scans from point clouds and depth images: values of the server's table. */
export type Cut = Readonly<Record<string, number>>;

export interface SensorState {
  /** The topic that is being read; null for none. */
  readonly reading: Signal<string | null>;
  /** Progress of reading it; null before it is known. */
  readonly progress: Signal<Making | null>;
  readonly failure: Signal<string | null>;
  /** Map another sensor of the log, or change its cut. */
  readonly use: (topic: string, cut: Cut | null) => Promise<void>;
  readonly cancel: () => void;
}

/** Changes the sensor that a session maps; `onUsed` is called with the topic afterwards. */
export function useSensor(session: string, onUsed: (topic: string) => void): SensorState {
  const reading = useSignal<string | null>(null);
  const progress = useSignal<Making | null>(null);
  const failure = useSignal<string | null>(null);
  const ending = useRef<AbortController | null>(null);
  useEffect(() => () => ending.current?.abort(), [session]);
  const use = async (topic: string, cut: Cut | null): Promise<void> => {
    ending.current?.abort();
    const own = new AbortController();
    ending.current = own;
    const name = newName();
    reading.value = topic;
    failure.value = null;
    const stop = followMaking(name, (making) => {
      progress.value = making;
    });
    try {
      const options = { query: { name }, body: { topic, cut }, ending: own.signal };
      await ask("PUT /api/sessions/{session_id}/sensor", { session_id: session }, options);
      onUsed(topic);
    } catch (error) {
      if (!own.signal.aborted) failure.value = (error as Error).message;
    }
    stop();
    if (ending.current === own) reading.value = null;
  };
  return { reading, progress, failure, use, cancel: () => ending.current?.abort() };
}
