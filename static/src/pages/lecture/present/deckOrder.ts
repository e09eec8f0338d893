/** Moving one of a list of slides: by its place, and by dragging its row. */

/** The list with the entry at `from` at the index `to` of the result. */
export function reordered<T>(list: readonly T[], from: number, to: number): readonly T[] {
  const next = [...list];
  const [one] = next.splice(from, 1);
  if (one !== undefined) next.splice(Math.max(0, Math.min(to, next.length)), 0, one);
  return next;
}

/** How many rows lie above a place, by their middles: the gap into which a row dropped there goes. Pixels. */
export const gapAt = (y: number, rows: readonly { readonly top: number; readonly bottom: number }[]): number =>
  rows.filter(({ top, bottom }) => (top + bottom) / 2 < y).length;

/** The index that a row at `from` has after it was dropped into a gap. */
export const indexAfter = (from: number, gap: number): number => (gap > from ? gap - 1 : gap);

/** The index that a key of the grip moves a row to, null for other keys. */
export function keyedIndex(key: string, from: number, count: number): number | null {
  const to = { ArrowUp: from - 1, ArrowDown: from + 1, Home: 0, End: count - 1 }[key];
  return to === undefined ? null : Math.max(0, Math.min(to, count - 1));
}
