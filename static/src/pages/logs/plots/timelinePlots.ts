/** What the plots below a log's timeline share with it. */

import { type Signal, useSignal } from "@preact/signals";
import type { ShownPlots } from "../../../wire/http";
import type { Span } from "../contents/series";

export interface TimelinePlotsState {
  readonly isOpen: Signal<boolean>;
  /** The number of scans at the pointer's place on the timeline; null where it is not on it. */
  readonly onTimeline: Signal<number | null>;
  /** The same of the pointer in the plots. */
  readonly inPlots: Signal<number | null>;
  /** The interval that all plots of the log show; null for the whole log. */
  readonly zoom: Signal<Span | null>;
}

/** At first as a link `shown` has it. */
export function useTimelinePlots(shown: ShownPlots | null = null): TimelinePlotsState {
  return {
    isOpen: useSignal(shown?.below ?? false),
    onTimeline: useSignal(null),
    inPlots: useSignal(null),
    zoom: useSignal(shown?.zoom ?? null),
  };
}
