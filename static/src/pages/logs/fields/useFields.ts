import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { ask } from "../../../wire/ask";
import type { SeriesAnswer, ShownPlots, TopicFieldsAnswer } from "../../../wire/http";
import type { Span } from "../contents/series";
import { type Chosen, keyOf } from "./fields";

const AGAIN_MS = 400;

/** The state of the plot of fields, in the dock and on the stage. */
export interface FieldsState {
  readonly chosen: Signal<readonly Chosen[]>;
  /** The key of the field on the horizontal axis; null for time. */
  readonly across: Signal<string | null>;
  /** Whether neither the visitor nor a link has chosen what is plotted: it starts with the speed. */
  readonly isNew: { current: boolean };
}

/** Initially that of a link `shown`. */
export function useFieldsState(session: string, shown: ShownPlots | null = null): FieldsState {
  const state: FieldsState = { chosen: useSignal([]), across: useSignal(null), isNew: useRef(false) };
  useEffect(() => {
    state.isNew.current = !shown;
    state.chosen.value = shown?.fields ?? [];
    state.across.value = shown?.across ?? null;
  }, [session]);
  return state;
}

export type Waiting<T> =
  | { readonly kind: "reading"; readonly progress: number }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "ready"; readonly value: T };

const isReading = (answer: object): answer is { readonly progress: number; readonly state: "reading" } =>
  "state" in answer && answer.state === "reading";

/** Repeat the request until the server has read the data; `ending` aborts it. */
async function asked<T extends object>(
  send: () => Promise<T | { readonly progress: number; readonly state: "reading" }>,
  ending: AbortSignal,
  show: (now: Waiting<T>) => void,
): Promise<void> {
  try {
    while (!ending.aborted) {
      const answer = await send();
      if (ending.aborted) return;
      if (!isReading(answer)) return show({ kind: "ready", value: answer });
      show({ kind: "reading", progress: answer.progress });
      await new Promise((done) => setTimeout(done, AGAIN_MS));
    }
  } catch (error) {
    if (!ending.aborted) show({ kind: "failed", why: (error as Error).message });
  }
}

/** The fields of all topics of a session's recording. */
export function useFieldNames(session: string): Waiting<readonly TopicFieldsAnswer[]> {
  const state = useSignal<Waiting<readonly TopicFieldsAnswer[]>>({ kind: "reading", progress: 0 });
  useEffect(() => {
    const abort = new AbortController();
    const what = "GET /api/sessions/{session_id}/contents/fields";
    void asked(
      () => ask(what, { session_id: session }, { ending: abort.signal }),
      abort.signal,
      (now) => {
        state.value = now.kind === "ready" ? { kind: "ready", value: now.value.topics } : now;
      },
    );
    return () => abort.abort();
  }, [session]);
  return state.value;
}

export type FoundSeries = ReadonlyMap<string, Waiting<SeriesAnswer>>;

/** The values of the chosen fields in an interval, `evenly` sampled for pairs of one time. */
export function useFieldSeries(
  session: string,
  chosen: readonly Chosen[],
  span: Span | null,
  evenly: boolean,
): FoundSeries {
  const loaded = useSignal<FoundSeries>(new Map());
  useEffect(() => {
    const abort = new AbortController();
    // The present values stay until the requested ones have arrived.
    loaded.value = new Map([...loaded.peek()].filter(([key]) => chosen.some((item) => keyOf(item) === key)));
    for (const item of chosen) {
      const query = {
        topic: item.topic,
        field: item.field,
        made: item.made,
        window: item.window,
        evenly,
        ...(span && { start: span[0], end: span[1] }),
      };
      const what = "GET /api/sessions/{session_id}/contents/field";
      void asked<SeriesAnswer>(
        () => ask(what, { session_id: session }, { query, ending: abort.signal }),
        abort.signal,
        (now) => {
          if (now.kind === "reading" && loaded.peek().get(keyOf(item))?.kind === "ready") return;
          loaded.value = new Map(loaded.peek()).set(keyOf(item), now);
        },
      );
    }
    return () => abort.abort();
  }, [session, chosen, span, evenly]);
  return loaded.value;
}
