/** The deck of slides: those of the lecture in the lecturer's order, and slides added by the lecturer. */

import { unpack } from "../../../packed";
import { LESSONS, type LessonId, sectionOf } from "../../lessons";

/** Properties of every slide. */
interface Common {
  readonly hidden?: boolean;
  /** Shown only in the speaker's window; for a section they replace its default notes. */
  readonly notes?: string;
  /** Planned duration; the speaker's window sums them. */
  readonly minutes?: number;
}

/** A section of the lecture: its question, its figure, its answer. */
interface SectionSlide extends Common {
  readonly kind: "section";
  readonly section: LessonId;
}

/** The derivation in a section, line by line. */
interface DerivationSlide extends Common {
  readonly kind: "derivation";
  readonly section: LessonId;
}

/** The start: the map of the lecture fills in. */
interface TitleSlide extends Common {
  readonly kind: "title";
  readonly title: string;
}

/** Text written by the lecturer; each paragraph is a step. */
interface TextSlide extends Common {
  readonly kind: "text";
  readonly title: string;
  readonly text: string;
}

/** A page of this service inside the slide: the lab in some state, or the view of a log. */
export interface PageSlide extends Common {
  readonly kind: "lab" | "log";
  readonly title: string;
  /** Path, query and fragment of the page. */
  readonly address: string;
}

export type Slide = TitleSlide | SectionSlide | DerivationSlide | TextSlide | PageSlide;

export interface Deck {
  readonly title: string;
  readonly slides: readonly Slide[];
}

/** Sections that have a derivation. */
const DERIVATIONS: readonly LessonId[] = ["cell"];
/** The lab comes before this section. */
const LAB_BEFORE: LessonId = "next";
const LAB: Slide = { kind: "lab", title: "Which setting changes the map the most?", address: "/lab.html" };

/** The default deck of the lecture. */
export const WHOLE_LECTURE: Deck = {
  title: "Occupancy grid mapping",
  slides: [
    { kind: "title", title: "Occupancy grid mapping" },
    ...LESSONS.flatMap(({ id }): Slide[] => [
      ...(id === LAB_BEFORE ? [LAB] : []),
      { kind: "section", section: id },
      ...(DERIVATIONS.includes(id) ? [{ kind: "derivation", section: id } as const] : []),
    ]),
  ],
};

/** The name of each slide in an address: that of its section, or its kind with a number. */
export function slideIds(deck: Deck): readonly string[] {
  const used = new Map<string, number>();
  return deck.slides.map((slide) => {
    const base =
      slide.kind === "section"
        ? slide.section
        : slide.kind === "derivation"
          ? `${slide.section}-derivation`
          : `own-${slide.kind}`;
    const count = (used.get(base) ?? 0) + 1;
    used.set(base, count);
    return count === 1 ? base : `${base}-${count}`;
  });
}

export const titleOf = (slide: Slide): string => {
  if ("title" in slide) return slide.title;
  const title = LESSONS.find(({ id }) => id === slide.section)?.title ?? slide.section;
  return slide.kind === "derivation" ? `${title}: the derivation` : title;
};

// --- files and links -------------------------------------------------------------------------------------------------

const FORMAT = "gridbloom_deck";
const VERSION = 1;
const MOST_SLIDES = 200;
export const LONGEST_TITLE = 120;
export const LONGEST_TEXT = 4000;
const MOST_MINUTES = 600;
const LONGEST_FILE = 1_000_000;
const KINDS = ["title", "section", "derivation", "text", "lab", "log"] as const;

/** The properties of a deck that are stored; {@link readDeck} reads them. */
export const writtenDeck = (deck: Deck): Readonly<Record<string, unknown>> => ({
  [FORMAT]: VERSION,
  title: deck.title,
  slides: deck.slides,
});

/** The error of a deck, in one sentence. */
export class DeckError extends Error {}

type Fields = Readonly<Record<string, unknown>>;

const isObject = (value: unknown): value is Fields =>
  typeof value === "object" && value !== null && !Array.isArray(value);

function textField(from: Fields, field: string, longest: number, where: string): string {
  const value = from[field];
  if (typeof value !== "string") throw new DeckError(`${where}: “${field}” is missing or is not a text.`);
  if (value.trim() === "") throw new DeckError(`${where}: “${field}” is empty.`);
  if (value.length > longest)
    throw new DeckError(`${where}: “${field}” has ${value.length} characters; at most ${longest} are allowed.`);
  return value;
}

function minutesField(value: unknown, where: string): number {
  if (typeof value !== "number" || !(value > 0 && value <= MOST_MINUTES))
    throw new DeckError(`${where}: “minutes” is not a number above 0 and up to ${MOST_MINUTES}.`);
  return value;
}

/** Pages that a slide can contain. */
const PAGES = { lab: /^\/lab\.html$/, log: /^\/(logs\.html|shared\/[\w-]+\/?)$/ } as const;

/**
 * The path, query and fragment of an address of this service. Throws a {@link DeckError} for another host, another
 * page, or text that is not an address.
 */
export function pageAddress(kind: "lab" | "log", text: string, where: string, origin = location.origin): string {
  let url: URL;
  try {
    url = new URL(text.trim(), origin);
  } catch {
    throw new DeckError(`${where}: “${text.slice(0, 60)}” is not an address.`);
  }
  if (url.origin !== origin)
    throw new DeckError(
      `${where}: the address is of ${url.host || url.protocol}; a deck shows only pages of this service.`,
    );
  if (!PAGES[kind].test(url.pathname))
    throw new DeckError(`${where}: ${url.pathname} is not a page of the ${kind === "lab" ? "lab" : "logs"}.`);
  return url.pathname + url.search + url.hash;
}

function readSlide(value: unknown, index: number): Slide {
  const where = `Slide ${index + 1}`;
  if (!isObject(value)) throw new DeckError(`${where} is not an object.`);
  const { kind } = value;
  if (!KINDS.some((known) => known === kind))
    throw new DeckError(`${where}: the kind “${String(kind)}” is not known; it is one of ${KINDS.join(", ")}.`);
  if (value.hidden !== undefined && typeof value.hidden !== "boolean")
    throw new DeckError(`${where}: “hidden” is neither true nor false.`);
  const common: Common = {
    ...(value.hidden ? { hidden: true } : {}),
    ...(value.minutes === undefined ? {} : { minutes: minutesField(value.minutes, where) }),
    ...(value.notes === undefined ? {} : { notes: textField(value, "notes", LONGEST_TEXT, where) }),
  };
  if (kind === "section" || kind === "derivation") {
    const name = textField(value, "section", LONGEST_TITLE, where);
    const section = LESSONS.find(({ id }) => id === sectionOf(name))?.id;
    if (!section) throw new DeckError(`${where}: the lecture has no section “${name}”.`);
    if (kind === "derivation" && !DERIVATIONS.includes(section))
      throw new DeckError(`${where}: the section “${name}” has no derivation.`);
    return { ...common, kind, section };
  }
  const title = textField(value, "title", LONGEST_TITLE, where);
  if (kind === "title") return { ...common, kind, title };
  if (kind === "text") return { ...common, kind, title, text: textField(value, "text", LONGEST_TEXT, where) };
  const page = kind as "lab" | "log";
  const address = pageAddress(page, textField(value, "address", LONGEST_FILE, where), where);
  return { ...common, kind: page, title, address };
}

/** Read a deck as written by {@link writtenDeck}. Throws a {@link DeckError} that names the error and its place. */
export function readDeck(value: unknown): Deck {
  if (!isObject(value) || !(FORMAT in value))
    throw new DeckError(`This is not a deck of Gridbloom: “${FORMAT}” is missing.`);
  if (value[FORMAT] !== VERSION)
    throw new DeckError(`The deck has version ${String(value[FORMAT])}; this page reads version ${VERSION}.`);
  const title = textField(value, "title", LONGEST_TITLE, "The deck");
  if (!Array.isArray(value.slides)) throw new DeckError("The deck: “slides” is missing or is not a list.");
  if (value.slides.length > MOST_SLIDES)
    throw new DeckError(`The deck has ${value.slides.length} slides; at most ${MOST_SLIDES} are allowed.`);
  const slides = value.slides.map(readSlide);
  if (!slides.some((slide) => !slide.hidden)) throw new DeckError("The deck has no slide that is shown.");
  return { title, slides };
}

/** Read the text of a deck's file. Throws a {@link DeckError}. */
export function readDeckFile(text: string): Deck {
  if (text.length > LONGEST_FILE)
    throw new DeckError(`The file has ${text.length} characters; a deck has at most ${LONGEST_FILE}.`);
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch (error) {
    throw new DeckError(`The file is not JSON: ${(error as Error).message}`);
  }
  return readDeck(value);
}

/** Read the characters of a deck's link. Rejects with a {@link DeckError}. */
export async function readDeckLink(letters: string): Promise<Deck> {
  let value: unknown;
  try {
    value = await unpack(letters);
  } catch {
    throw new DeckError("The link of the deck is incomplete or damaged.");
  }
  return readDeck(value);
}
