/** Moving a slide within the list: by its position, and by dragging its row. */

import { LECTURE_PARTS, type Part } from "../../lessons";
import { type Slide, WHOLE_LECTURE } from "./deck";

/** Whether a slide is about a section of one part of the lecture. */
const isAbout = ({ lessons }: Part, slide: Slide): boolean =>
  "section" in slide && lessons.some(({ id }) => id === slide.section);

export const hasPart = (slides: readonly Slide[], part: Part): boolean => slides.some((slide) => isAbout(part, slide));

const [LECTURE_TITLE] = WHOLE_LECTURE.slides.filter(({ kind }) => kind === "title");

/** The title slide of the lecture with the name of a part, or without one. A title by the lecturer stays unchanged. */
function named(slide: Slide, part: Part | null): Slide {
  if (slide.kind !== "title" || LECTURE_TITLE?.kind !== "title") return slide;
  const titled = (part: Part) => `${LECTURE_TITLE.title}: ${part.title}`;
  const isOwn = slide.title !== LECTURE_TITLE.title && !LECTURE_PARTS.some((part) => slide.title === titled(part));
  return isOwn ? slide : { ...slide, title: part ? titled(part) : LECTURE_TITLE.title };
}

/** The slides with all hidden but those of one part; its title slide has the part's name. */
export const onlyPart = (slides: readonly Slide[], part: Part): readonly Slide[] =>
  slides.map((slide) =>
    slide.kind === "title" || isAbout(part, slide) ? shown(named(slide, part)) : { ...slide, hidden: true },
  );

/** All slides shown. */
export const allShown = (slides: readonly Slide[]): readonly Slide[] =>
  slides.map((slide) => shown(named(slide, null)));

/** The list with the entry at `from` moved to the index `to` of the result. */
export function reordered<T>(list: readonly T[], from: number, to: number): readonly T[] {
  const next = [...list];
  const [moved] = next.splice(from, 1);
  if (moved !== undefined) next.splice(Math.max(0, Math.min(to, next.length)), 0, moved);
  return next;
}

/**
 * The gap for a row dropped at a height, by the middles of the rows: 0 above the first one, their number below the last
 * one. Rows that are not displayed have no height and are skipped. Pixels.
 */
export function gapAt(y: number, rows: readonly { readonly top: number; readonly bottom: number }[]): number {
  const below = rows.findIndex(({ top, bottom }) => bottom > top && (top + bottom) / 2 >= y);
  return below < 0 ? rows.length : below;
}

/** The index of a row at `from` after it is dropped into a gap. */
export const indexAfter = (from: number, gap: number): number => (gap > from ? gap - 1 : gap);

/**
 * The index to which a key on the grip moves a row; null for other keys. `isShown` has an entry for each slide: one key
 * press moves a shown slide past all neighbouring hidden ones, because otherwise the visible order would not change.
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

/** The number of a shown slide among the shown slides, from 1, as in the bar above the slides. */
export const numberOf = (isShown: readonly boolean[], index: number): number =>
  isShown.slice(0, index + 1).filter(Boolean).length;

/** The slides with some shown and all others hidden, as the start of a short deck. */
export function only<T extends { readonly hidden?: boolean }>(
  slides: readonly T[],
  isWanted: (slide: T, index: number) => boolean,
): readonly T[] {
  return slides.map((slide, i) => (isWanted(slide, i) ? shown(slide) : { ...slide, hidden: true }));
}

/** A slide that is no longer hidden. */
export function shown<T extends { readonly hidden?: boolean }>(slide: T): T {
  const { hidden, ...rest } = slide;
  return (hidden ? rest : slide) as T;
}
