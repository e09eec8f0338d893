/** The arithmetic of a timeline over `count` scans: index 0 is before the first scan, `count` after the last. */

/** The index at an offset on the track, in px. */
export function indexAt(offset: number, width: number, count: number): number {
  if (!(width > 0) || count <= 0) return 0;
  return Math.round(Math.min(1, Math.max(0, offset / width)) * count);
}

/** Position of an index on the track, 0 … 1. */
export function placeOf(index: number, count: number): number {
  return count > 0 ? Math.min(1, Math.max(0, index / count)) : 0;
}

/** The index after a key press: arrow keys one scan, with Shift ten, Page keys a twentieth, Home and End the ends. */
export function keyedIndex(key: string, shift: boolean, index: number, count: number): number | null {
  const page = Math.max(1, Math.round(count / 20));
  const moves: Record<string, number> = {
    ArrowRight: shift ? 10 : 1,
    ArrowUp: shift ? 10 : 1,
    ArrowLeft: shift ? -10 : -1,
    ArrowDown: shift ? -10 : -1,
    PageUp: page,
    PageDown: -page,
    Home: -count,
    End: count,
  };
  const move = moves[key];
  return move === undefined ? null : Math.min(count, Math.max(0, index + move));
}
