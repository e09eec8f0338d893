/** State shared by a log's timeline and the plots below it. */

import { type Signal, useSignal } from "@preact/signals";
import type { ShownPlots } from "../../../wire/http";
import type { Span } from "../contents/series";

export interface TimelinePlotsState {
  readonly isOpen: Signal<boolean>;
  /** The number of scans at the pointer on the timeline; null if the pointer is elsewhere. */
  readonly onTimeline: Signal<number | null>;
  /** The same for the pointer in the plots. */
  readonly inPlots: Signal<number | null>;
  /** The interval that all plots of the log show; null for the whole log. */
  readonly zoom: Signal<Span | null>;
}

/** Initially that of a link `shown`. */
export function useTimelinePlots(shown: ShownPlots | null = null): TimelinePlotsState {
  return {
    isOpen: useSignal(shown?.below ?? false),
    onTimeline: useSignal(null),
    inPlots: useSignal(null),
    zoom: useSignal(shown?.zoom ?? null),
  };
}
