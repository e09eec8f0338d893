/** A choice of the lecture's slides for one lesson of 45 minutes, with the minutes that each is planned to take. */

import type { LessonId } from "../../lessons";
import { type Deck, type Slide, WHOLE_LECTURE } from "./deck";

type Planned = readonly [slide: LessonId | "cell-derivation" | "title", minutes: number];

/** Filter, sensor model and traversal, then what goes wrong, and the use of the map. */
const PLANNED: readonly Planned[] = [
  ["title", 1],
  ["grid", 2],
  ["cell", 3],
  ["cell-derivation", 4],
  ["log-odds", 2],
  ["model", 4],
  ["window", 2],
  ["rays", 4],
  ["algorithm", 3],
  ["no-return", 2],
  ["mount", 2],
  ["people", 2],
  ["odometry", 3],
  ["file", 2],
  ["path", 3],
  ["stack", 1],
  ["next", 1],
];
/** Comes after the algorithm. */
const LOG: Slide = { kind: "log", title: "The map of a real log", address: "/logs.html", minutes: 4 };

const nameOf = (slide: Slide): string =>
  slide.kind === "section" ? slide.section : slide.kind === "derivation" ? `${slide.section}-derivation` : slide.kind;

const minutesOf = new Map<string, number>(PLANNED);

export const SHORT_LECTURE: Deck = {
  title: `${WHOLE_LECTURE.title} in 45 minutes`,
  slides: WHOLE_LECTURE.slides.flatMap((slide): Slide[] => {
    const name = nameOf(slide);
    const minutes = minutesOf.get(name);
    const now = minutes === undefined ? { ...slide, hidden: true } : { ...slide, minutes };
    return name === "algorithm" ? [now, LOG] : [now];
  }),
};
