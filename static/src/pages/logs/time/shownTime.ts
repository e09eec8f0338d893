import type { Signal } from "@preact/signals";
import type { Store } from "../../../store/store";
import { isBoolean, kept } from "../../../ui/browser/kept";
import { timeText } from "./timeText";

/** Whether times are shown in UTC, where the log's clock tells it, and not from the log's first scan. */
export const inUtc: Signal<boolean> = kept("gridbloom.logs.utc", false, isBoolean);

/** The time of the log's first scan where times are shown in UTC, s since 1970; else null. */
export const shownStart = (store: Store): number | null =>
  inUtc.value ? (store.hello.value?.log?.start_s ?? null) : null;

/** A moment of a log, s from its first scan, as the visitor wants times. */
export const shownTime = (store: Store, seconds: number): string => timeText(seconds, shownStart(store));

/** The same without date and zone, for lists. */
export function clockTime(store: Store, seconds: number): string {
  const text = shownTime(store, seconds);
  return shownStart(store) === null ? text : text.slice(11, 23);
}
