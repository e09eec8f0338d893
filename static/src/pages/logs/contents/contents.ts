/** Rates and ages of what a log's recording holds, as text. */

/** A rate as text: 10.0 Hz, and for slow topics the time between two messages. */
export function rateLabel(rate: number | null): string {
  if (rate === null) return "–";
  if (rate >= 0.1) return `${rate < 100 ? rate.toFixed(1) : Math.round(rate)} Hz`;
  return `every ${Math.round(1 / rate)} s`;
}

/** An age as text: 12 ms, 3.4 s, 2:05. */
export function ageLabel(seconds: number): string {
  if (seconds < 1) return `${Math.round(1000 * seconds)} ms`;
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}
