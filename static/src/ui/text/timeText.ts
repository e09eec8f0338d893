/** Times of a recording to the millisecond: from its first scan, or in UTC. */

/** Seconds since the log's first scan as m:ss.mmm; with the time of that scan in seconds since 1970, in UTC. */
export function timeText(seconds: number, startS: number | null = null): string {
  if (startS !== null) {
    const text = new Date(Math.round((startS + seconds) * 1000)).toISOString();
    return `${text.replace("T", " ").replace("Z", "")} UTC`;
  }
  const sign = seconds < 0 ? "−" : "";
  const ms = Math.round(Math.abs(seconds) * 1000);
  const rest = `${pad(Math.floor(ms / 1000) % 60, 2)}.${pad(ms % 1000, 3)}`;
  const minutes = Math.floor(ms / 60_000);
  const hours = Math.floor(minutes / 60);
  return `${sign}${hours > 0 ? `${hours}:${pad(minutes % 60, 2)}` : minutes}:${rest}`;
}

const pad = (value: number, digits: number): string => String(value).padStart(digits, "0");

/**
 * The seconds since the log's first scan that a visitor writes: seconds ("73.4"), m:ss, h:mm:ss, or a time in UTC,
 * of the day on which the log begins where no date is given. Null for what is no time.
 */
export function readTime(text: string, startS: number | null): number | null {
  const plain = text.trim().replace(/\s*(UTC|Z|s)$/i, "");
  const dated = /^(\d{4}-\d{2}-\d{2})[ T](\d{1,2}:\d{2}(?::\d{2}(?:[.,]\d+)?)?)$/.exec(plain);
  if (dated) {
    if (startS === null) return null;
    const day = Date.parse(`${dated[1]}T00:00:00Z`);
    const inDay = ofClock(dated[2] ?? "", true);
    return Number.isNaN(day) || inDay === null ? null : day / 1000 + inDay - startS;
  }
  if (/^\d+([.,]\d+)?$/.test(plain)) return Number(plain.replace(",", "."));
  const isUtc = startS !== null && /UTC|Z$/i.test(text.trim());
  const clock = ofClock(plain, isUtc);
  if (clock === null || !isUtc) return clock;
  return Math.floor((startS as number) / 86_400) * 86_400 + clock - (startS as number);
}

/** Seconds of m:ss or h:mm:ss; of two numbers as hours and minutes where `isDay`. */
function ofClock(text: string, isDay: boolean): number | null {
  const parts = text.replace(",", ".").split(":");
  if (parts.length < 2 || parts.length > 3 || !parts.every((part) => /^\d+(\.\d+)?$/.test(part))) return null;
  const numbers = parts.map(Number);
  if (numbers.length === 2) numbers.splice(isDay ? 2 : 0, 0, 0);
  const [hours = 0, minutes = 0, seconds = 0] = numbers;
  return minutes < 60 || hours === 0 ? 3600 * hours + 60 * minutes + seconds : null;
}
