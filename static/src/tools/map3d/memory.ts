/** Numbers of bytes as text and as bars. */

const UNITS = ["B", "kB", "MB", "GB"];
/** Bytes of an empty bar. */
const LEAST = 1000;

/** A number of bytes with three digits. */
export function sizeOf(bytes: number): string {
  let value = bytes;
  let unit = 0;
  while (value >= 999.5 && unit < UNITS.length - 1) {
    value /= 1000;
    unit++;
  }
  const digits = unit === 0 || value >= 99.5 ? 0 : value >= 9.95 ? 1 : 2;
  return `${value.toFixed(digits)} ${UNITS[unit]}`;
}

/** The share 0 … 1 of a bar for a number of bytes on a logarithmic scale that ends at `most`. */
export function shareOf(bytes: number, most: number): number {
  if (bytes <= LEAST || most <= LEAST) return 0;
  return Math.min(1, Math.log(bytes / LEAST) / Math.log(most / LEAST));
}
