/** Showing only the slides of one part of the lecture: each is about as much as one lesson. */

import { LECTURE_PARTS, type Part } from "../../lessons";
import { type Slide, WHOLE_LECTURE } from "./deck";
import { shown } from "./deckOrder";

/** Whether a slide is about a section of one part of the lecture. */
const isAbout = ({ lessons }: Part, slide: Slide): boolean =>
  "section" in slide && lessons.some(({ id }) => id === slide.section);

export const hasPart = (slides: readonly Slide[], part: Part): boolean => slides.some((one) => isAbout(part, one));

const [LECTURE_TITLE] = WHOLE_LECTURE.slides.filter(({ kind }) => kind === "title");

/** The title slide of the lecture with the name of a part, or without one; a lecturer's own title stays as it is. */
function named(slide: Slide, part: Part | null): Slide {
  if (slide.kind !== "title" || LECTURE_TITLE?.kind !== "title") return slide;
  const titled = (one: Part) => `${LECTURE_TITLE.title}: ${one.title}`;
  const isOwn = slide.title !== LECTURE_TITLE.title && !LECTURE_PARTS.some((one) => slide.title === titled(one));
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
