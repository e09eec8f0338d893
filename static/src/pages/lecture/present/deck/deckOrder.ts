/** Moving one of a list of slides: by its place, and by dragging its row. */

import { LECTURE_PARTS, type Part } from "../../lessons";
import { type Slide, WHOLE_LECTURE } from "./deck";

/** Whether a slide is about a section of one part of the lecture. */
const isAbout = ({ lessons }: Part, slide: Slide): boolean =>
  "section" in slide && lessons.some(({ id }) => id === slide.section);

export const hasPart = (slides: readonly Slide[], part: Part): boolean => slides.some((slide) => isAbout(part, slide));

const [LECTURE_TITLE] = WHOLE_LECTURE.slides.filter(({ kind }) => kind === "title");

/** The title slide of the lecture with the name of a part, or without one; a lecturer's own title stays as it is. */
function named(slide: Slide, part: Part | null): Slide {
  if (slide.kind !== "title" || LECTURE_TITLE?.kind !== "title") return slide;
  const titled = (part: Part) => `${LECTURE_TITLE.title}: ${part.title}`;
  const isOwn = slide.title !== LECTURE_TITLE.title && !LECTURE_PARTS.some((part) => slide.title === titled(part));
  return isOwn ? slide : { ...slide, title: part ? titled(part) : LECTURE_TITLE.title };
}

/** The slides with all but those of one part hidden; its title slide has the part's name. */
export const onlyPart = (slides: readonly Slide[], part: Part): readonly Slide[] =>
  slides.map((slide) =>
    slide.kind === "title" || isAbout(part, slide) ? shown(named(slide, part)) : { ...slide, hidden: true },
  );

/** All slides shown. */
export const allShown = (slides: readonly Slide[]): readonly Slide[] =>
  slides.map((slide) => shown(named(slide, null)));

/** The list with the entry at `from` at the index `to` of the result. */
export function reordered<T>(list: readonly T[], from: number, to: number): readonly T[] {
  const next = [...list];
  const [moved] = next.splice(from, 1);
  if (moved !== undefined) next.splice(Math.max(0, Math.min(to, next.length)), 0, moved);
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
