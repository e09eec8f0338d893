/** Showing only the slides of one part of the lecture: each is about as much as one lesson. */

import { LECTURE_PARTS, type Part } from "../../lessons";
import type { Slide } from "./deck";
import { shown } from "./deckOrder";

/** Whether a slide is about a section of one part of the lecture. */
const isAbout = ({ lessons }: Part, slide: Slide): boolean =>
  "section" in slide && lessons.some(({ id }) => id === slide.section);

export const hasPart = (slides: readonly Slide[], part: Part): boolean => slides.some((one) => isAbout(part, one));

const BETWEEN = ": ";

/** A title slide with the name of a part after its title, or without one. */
function named(slide: Slide, part: Part | null): Slide {
  if (slide.kind !== "title") return slide;
  const old = LECTURE_PARTS.find((one) => slide.title.endsWith(BETWEEN + one.title));
  const title = old ? slide.title.slice(0, -(BETWEEN + old.title).length) : slide.title;
  return { ...slide, title: part ? title + BETWEEN + part.title : title };
}

/** The slides with all but those of one part hidden; its title slide has the part's name. */
export const onlyPart = (slides: readonly Slide[], part: Part): readonly Slide[] =>
  slides.map((slide) =>
    slide.kind === "title" || isAbout(part, slide) ? shown(named(slide, part)) : { ...slide, hidden: true },
  );

/** All slides shown. */
export const allShown = (slides: readonly Slide[]): readonly Slide[] =>
  slides.map((slide) => shown(named(slide, null)));
