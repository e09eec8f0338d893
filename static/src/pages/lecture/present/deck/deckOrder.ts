/** Moving one of a list of slides: by its place, and by dragging its row. */

/** The list with the entry at `from` at the index `to` of the result. */
export function reordered<T>(list: readonly T[], from: number, to: number): readonly T[] {
  const next = [...list];
  const [one] = next.splice(from, 1);
  if (one !== undefined) next.splice(Math.max(0, Math.min(to, next.length)), 0, one);
  return next;
}

/**
 * The gap into which a row dropped at a height goes, by the middles of the rows: 0 above the first one, their number
 * below the last one. Rows that are not displayed have no height and take nothing. Pixels.
 */
export function gapAt(y: number, rows: readonly { readonly top: number; readonly bottom: number }[]): number {
  const below = rows.findIndex(({ top, bottom }) => bottom > top && (top + bottom) / 2 >= y);
  return below < 0 ? rows.length : below;
}

/** The index that a row at `from` has after it was dropped into a gap. */
export const indexAfter = (from: number, gap: number): number => (gap > from ? gap - 1 : gap);

/**
 * The index that a key of the grip moves a row to, null for other keys. `isShown` says of each slide whether it is
 * shown: a slide that is goes past those that are not with one key, or its move would change nothing.
 */
export function keyedIndex(key: string, from: number, isShown: readonly boolean[]): number | null {
  const last = isShown.length - 1;
  if (key === "Home" || key === "End") return key === "Home" ? 0 : last;
  const step = { ArrowUp: -1, ArrowDown: 1 }[key];
  if (step === undefined) return null;
  let to = from + step;
  while (isShown[from] && isShown[to] === false) to += step;
  return to < 0 || to > last ? from : to;
}

/** The number of a slide that is shown among those that are, from 1, as the bar above the slides has it. */
export const numberOf = (isShown: readonly boolean[], index: number): number =>
  isShown.slice(0, index + 1).filter(Boolean).length;

/** The slides with all but some hidden, with which a short deck begins. */
export function only<T extends { readonly hidden?: boolean }>(
  slides: readonly T[],
  isWanted: (slide: T, index: number) => boolean,
): readonly T[] {
  return slides.map((slide, i) => (isWanted(slide, i) ? shown(slide) : { ...slide, hidden: true }));
}

/** A slide that is not hidden any more. */
export function shown<T extends { readonly hidden?: boolean }>(slide: T): T {
  const { hidden, ...rest } = slide;
  return (hidden ? rest : slide) as T;
}
