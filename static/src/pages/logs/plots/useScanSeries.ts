import { type ReadonlySignal, type Signal, useComputed, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { showAnswer } from "../../../ui/browser/attempts";
import { ask } from "../../../wire/ask";
import type { ScanSeries } from "../../../wire/http";
import type { Span } from "../contents/series";
import { selectedMoments } from "../time/scanTimes";
import { wholeSpan } from "./strips";

interface ScanSeriesState {
  /** The quantities by scan along the session's trajectory, in the interval `zoom`; null until they are known. */
  readonly series: Signal<ScanSeries | null>;
  readonly failure: Signal<string | null>;
  /** The interval of the whole log. */
  readonly whole: Signal<Span>;
}

export function useScanSeries(store: Store, session: string, zoom: Signal<Span | null>): ScanSeriesState {
  const series = useSignal<ScanSeries | null>(null);
  const failure = useSignal<string | null>(null);
  const whole = useSignal<Span>([0, 1]);
  const trajectory = store.trajectory.value;
  const span = zoom.value;
  useEffect(() => {
    const options = span ? { query: { start: span[0], end: span[1] } } : {};
    return showAnswer(
      (ending) => ask("GET /api/sessions/{session_id}/scan-series", { session_id: session }, { ...options, ending }),
      failure,
      (found) => {
        series.value = found;
        if (!span) whole.value = wholeSpan(found.times);
      },
    );
  }, [session, trajectory, span]);
  return { series, failure, whole };
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
