/** Rates and ages of the contents of a recording as text. */

import { timeText } from "../../../ui/text/timeText";

/** A rate as text: 10.0 Hz; for slow topics the interval of messages. */
export function rateLabel(rate: number | null): string {
  if (rate === null) return "–";
  if (rate >= 0.1) return `${rate < 100 ? rate.toFixed(1) : Math.round(rate)} Hz`;
  return `every ${Math.round(1 / rate)} s`;
}

/** An age as text, to the millisecond: 12 ms, 3.400 s, 2:05.200 min. */
export function ageLabel(seconds: number): string {
  if (seconds < 1) return `${Math.round(1000 * seconds)} ms`;
  if (seconds < 60) return `${seconds.toFixed(3)} s`;
  return `${timeText(seconds)} ${seconds < 3600 ? "min" : "h"}`;
}
