import { type ReadonlySignal, type Signal, useComputed, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Store } from "../../../store/store";
import { showAnswer } from "../../../ui/browser/attempts";
import { ask } from "../../../wire/ask";
import type { ScanSeries } from "../../../wire/http";
import type { Span } from "../contents/series";
import { selectedMoments } from "../time/scanTimes";
import { wholeSpan } from "./strips";

/** The quantities by scan of a log, shared by all plots over its scans. */
export interface ScanSeriesState {
  /** The quantities along the session's trajectory, in the visible interval; null until they are known. */
  readonly series: Signal<ScanSeries | null>;
  readonly failure: Signal<string | null>;
  /** The interval of the whole log. */
  readonly whole: Signal<Span>;
  /** How many components show the numbers: they are asked for while there are any. */
  readonly users: Signal<number>;
}

/** Ask for the numbers of `session` in the interval `zoom`, once for all components that show them. */
export function useScanSeries(store: Store, session: string, zoom: Signal<Span | null>): ScanSeriesState {
  const series = useSignal<ScanSeries | null>(null);
  const failure = useSignal<string | null>(null);
  const whole = useSignal<Span>([0, 1]);
  const users = useSignal(0);
  const isUsed = useComputed(() => users.value > 0).value;
  const trajectory = store.trajectory.value;
  const span = zoom.value;
  const before = useRef<string | null>(null);
  useEffect(() => {
    // a link's interval is for the trajectory that comes first
    if (trajectory && before.current !== null && before.current !== trajectory.name) zoom.value = null;
    if (trajectory) before.current = trajectory.name;
  }, [trajectory]);
  const answered = useRef<readonly unknown[]>([]); // what the series answers, which is not asked again
  useEffect(() => {
    const question = [session, trajectory, span];
    if (!isUsed || question.every((part, n) => part === answered.current[n])) return;
    const options = span ? { query: { start: span[0], end: span[1] } } : {};
    return showAnswer(
      (ending) => ask("GET /api/sessions/{session_id}/scan-series", { session_id: session }, { ...options, ending }),
      failure,
      (found) => {
        answered.current = question;
        series.value = found;
        if (!span) whole.value = wholeSpan(found.times);
      },
    );
  }, [session, trajectory, span, isUsed]);
  return useMemo(() => ({ series, failure, whole, users }), []);
}

/** Have the numbers of `state` asked for while the calling component is shown. */
export function useUsed({ users }: ScanSeriesState): void {
  useEffect(() => {
    users.value += 1;
    return () => {
      users.value -= 1;
    };
  }, [users]);
}

/** Positions on the axis of `series`: of the map's time, null for none, and of what is selected in all views. */
export function useMoments(
  store: Store,
  series: ReadonlySignal<ScanSeries | null>,
): { readonly now: ReadonlySignal<number | null>; readonly selected: ReadonlySignal<readonly number[]> } {
  const now = useComputed(() => {
    const [frame, way] = [store.frame.value, store.trajectory.value];
    if (!frame || !way || frame.index === 0) return null;
    return series.value?.axis === "scan" ? frame.index - 1 : frame.stamp;
  });
  const selected = useComputed(() =>
    selectedMoments(store).map(({ scan, seconds }) => (series.value?.axis === "scan" ? scan : seconds)),
  );
  return { now, selected };
}
