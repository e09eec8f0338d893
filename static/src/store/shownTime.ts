import type { Signal } from "@preact/signals";
import { isBoolean, kept } from "../ui/browser/kept";
import { timeText } from "../ui/text/timeText";
import type { Store } from "./store";

/** Whether times are shown in UTC, if the log's clock provides it, instead of relative to the log's first scan. */
export const inUtc: Signal<boolean> = kept("gridbloom.logs.utc", false, isBoolean);

/** The time of the log's first scan if times are shown in UTC, s since 1970; otherwise null. */
export const shownStart = (store: Store): number | null =>
  inUtc.value ? (store.hello.value?.log?.start_s ?? null) : null;

/** A moment of a log, s from its first scan, in the visitor's choice of times. */
export const shownTime = (store: Store, seconds: number): string => timeText(seconds, shownStart(store));

/** The same, or for a log without times the number of the scan, from 1. */
export const momentText = (store: Store, seconds: number, scan: number): string =>
  (store.hello.value?.log?.duration_s ?? 0) > 0 ? shownTime(store, seconds) : `scan ${scan}`;

/** A moment without date and zone, for lists. */
export function clockTime(store: Store, seconds: number): string {
  const text = shownTime(store, seconds);
  return shownStart(store) === null ? text : text.slice(11, 23);
}
