/**
 * Where the presentation is: `?present#SLIDE/STEP&kept=NAME` in the address; a deck other than the whole lecture is
 * kept by the browser under that name. A link that opens a deck elsewhere holds it: `&deck=LETTERS`. `?present=view`
 * shows a slide without controls, in the speaker's window.
 */

import { computed, signal } from "@preact/signals";
import { pack } from "../../packed";
import { LESSONS, type LessonId, sectionOf } from "../lessons";
import { type Deck, readDeckLink, type Slide, slideIds, WHOLE_LECTURE, writtenDeck } from "./deck/deck";
import { keepDeck, keptDeck } from "./deck/keptDecks";
import { QUESTIONS, type Question } from "./questions";

const mode = new URLSearchParams(location.search).get("present");

/** Whether slides are shown, not the lecture as a text. */
export const presenting = signal(mode !== null);
/** Whether this page is a picture of a slide in the speaker's window. */
export const isPreview = mode === "view";
export const deck = signal<Deck>(WHOLE_LECTURE);
export const blank = signal(false);
/** The options that the audience has chosen, by the slide's name. */
export const predicted = signal<Readonly<Record<string, number>>>({});

export interface Place {
  readonly index: number;
  readonly step: number;
}

export const place = signal<Place>({ index: 0, step: 0 });
export const slides = computed(() => deck.value.slides);
export const ids = computed(() => slideIds(deck.value));
export const slide = computed<Slide | undefined>(() => slides.value[place.value.index]);

/** Past the last step of every slide: where an address names it, the slide shows its last one. */
export const LAST_STEP = 98;

/** What a slide of a section shows after each step. */
export type Stage = "ask" | "predict" | "figure" | "answer";

export const questionOf = (of: Slide | undefined): Question | undefined =>
  of?.kind === "section" ? QUESTIONS[of.section] : undefined;

const stagesOf = (question: Question | undefined): readonly Stage[] =>
  question ? ["ask", ...(question.options ? (["predict"] as const) : []), "figure", "answer"] : ["figure"];

export const paragraphsOf = (text: string): readonly string[] =>
  text.split(/\n\s*\n/).filter((paragraph) => paragraph.trim());

/** How many steps a slide has, at least one. Lines of a derivation are counted on the page. */
export function stepsOf(of: Slide): number {
  switch (of.kind) {
    case "section":
      return stagesOf(questionOf(of)).length;
    case "derivation":
      return Math.max(1, document.querySelectorAll(`#${of.section} .derivation-line`).length);
    case "text":
      return Math.max(1, paragraphsOf(of.text).length);
    default:
      return 1;
  }
}

/** The stage of the section on the present slide. */
export const stage = computed<Stage>(() => stagesOf(questionOf(slide.value))[place.value.step] ?? "figure");

/** What of a section the present slide shows, if it does. */
export function shownOf(section: string): "section" | "derivation" | null {
  const now = slide.value;
  if (!presenting.value || !now || !("section" in now) || now.section !== section) return null;
  return now.kind;
}

// --- moving ----------------------------------------------------------------------------------------------------------

/** The place one step on (1) or back (−1); with `whole`, the beginning of another slide. Stays at the ends. */
export function stepped(from: Place, by: 1 | -1, whole: boolean, list: readonly Slide[], steps = stepsOf): Place {
  const now = list[from.index];
  const step = from.step + by;
  if (now && !whole && step >= 0 && step < steps(now)) return { index: from.index, step };
  for (let index = from.index + by; index >= 0 && index < list.length; index += by) {
    const next = list[index];
    if (next && !next.hidden) return { index, step: by < 0 && !whole ? steps(next) - 1 : 0 };
  }
  return whole && by < 0 ? { index: from.index, step: 0 } : from;
}

/** The place of the first slide (1: seen from before it) or the last one that is shown. */
export function endOf(list: readonly Slide[], first: boolean): Place {
  const index = first ? list.findIndex((slide) => !slide.hidden) : list.findLastIndex((slide) => !slide.hidden);
  return { index: Math.max(0, index), step: 0 };
}

export function goTo(next: Place): void {
  place.value = next;
  blank.value = false;
  writeAddress();
}

export const move = (by: 1 | -1, whole = false): void => goTo(stepped(place.peek(), by, whole, slides.peek()));

/** Number of the present slide among those that are shown, and how many these are. */
export const count = computed(() => {
  const shown = slides.value.map((slide, i) => i === place.value.index || !slide.hidden);
  const total = shown.filter(Boolean).length;
  return { number: shown.slice(0, place.value.index + 1).filter(Boolean).length, total };
});

// --- the address -----------------------------------------------------------------------------------------------------

/** What the address says of the deck; empty for the whole lecture. */
let deckInAddress = "";
/** The name under which the browser keeps the deck. */
let keptAs: string | undefined;
/** How often the deck was changed: the pictures of slides look at it again when their address differs. */
let changes = 0;

/** Keep the deck and have the address name it; where the browser keeps nothing, the address holds it. */
async function keep(of: Deck): Promise<void> {
  if (of === WHOLE_LECTURE) {
    keptAs = undefined;
    deckInAddress = "";
    return;
  }
  keptAs = keepDeck(of, keptAs) ?? undefined;
  deckInAddress = keptAs ? `&kept=${keptAs}.${++changes}` : `&deck=${await pack(writtenDeck(of))}`;
}

/** The fragment that names a slide and its step, without the deck. */
export const placeHashOf = (at: Place): string =>
  `#${ids.peek()[at.index] ?? ""}${at.step > 0 ? `/${at.step + 1}` : ""}`;

export const hashOf = (at: Place): string => placeHashOf(at) + deckInAddress;

/** The section whose text belongs to the present slide. */
export function sectionOfSlide(): string {
  for (let index = place.peek().index; index >= 0; index--) {
    const slide = slides.peek()[index];
    if (slide && "section" in slide) return slide.section;
  }
  return LESSONS[0].id;
}

function writeAddress(): void {
  const query = presenting.peek() ? `?present${isPreview ? "=view" : ""}` : "";
  const hash = presenting.peek() ? hashOf(place.peek()) : `#${sectionOfSlide()}`;
  history.replaceState(null, "", location.pathname + query + hash);
}

/** Show a changed deck under the name of the present one, and go to a place of it. */
export async function changeDeck(next: Deck, at: Place = endOf(next.slides, true)): Promise<void> {
  await keep(next);
  deck.value = next;
  goTo(at);
}

/** Show another deck, and go to a place of it. */
export function takeDeck(next: Deck, at?: Place): Promise<void> {
  keptAs = undefined;
  return changeDeck(next, at);
}

/** Show one slide at a step, as a follower of a class, who has no other slide of the lecturer's deck. */
export function showOnly(only: Slide, step: number): void {
  deckInAddress = "";
  deck.value = { title: "", slides: [only] };
  place.value = { index: 0, step };
}

/** The link that opens a deck at its beginning. */
export async function deckLink(of: Deck): Promise<string> {
  const hash = of === WHOLE_LECTURE ? "" : `#&deck=${await pack(writtenDeck(of))}`;
  return new URL(`${location.pathname}?present${hash}`, location.href).href;
}

const KEPT = /^&kept=(\w+)/;

/** Show the deck of an address. Rejects with a DeckError, and shows the same as before, if there is none. */
async function readDeckOf(address: string): Promise<void> {
  const name = KEPT.exec(address)?.[1];
  let loaded = WHOLE_LECTURE;
  if (name) loaded = keptDeck(name);
  else if (address) loaded = await readDeckLink(address.slice("&deck=".length));
  keptAs = name;
  if (isPreview) deckInAddress = address;
  else await keep(loaded);
  deck.value = loaded;
}

/** Follow the address: take its deck, slide and step. Rejects with a DeckError, and keeps the deck, if it is damaged. */
export async function readAddress(): Promise<void> {
  const [name = "", ...rest] = location.hash.slice(1).split("&");
  const deckOption = rest.map((option) => `&${option}`).find((option) => /^&(kept|deck)=/.test(option)) ?? "";
  let problem: unknown = null;
  if (deckOption !== deckInAddress && presenting.peek()) {
    try {
      await readDeckOf(deckOption);
    } catch (error) {
      problem = error;
    }
  }
  const [id = "", step = "1"] = name.split("/");
  const index = ids.peek().indexOf(sectionOf(decodeURIComponent(id)));
  const at = slides.peek()[index];
  if (at) {
    // In a picture of a slide the lines of a derivation are rendered afterwards.
    const most = isPreview && at.kind === "derivation" ? LAST_STEP : stepsOf(at) - 1;
    place.value = { index, step: Math.min(most, Math.max(0, (Number.parseInt(step, 10) || 1) - 1)) };
  } else if (presenting.peek()) {
    place.value = endOf(slides.peek(), true);
  }
  if (problem) throw problem;
  if (deckOption && presenting.peek() && deckOption !== deckInAddress) writeAddress();
}

/** Start presenting at a section of the text, or end and write the section of the slide into the address. */
export function setPresenting(on: boolean, section?: LessonId): void {
  const index = slides.peek().findIndex((slide) => slide.kind === "section" && slide.section === section);
  presenting.value = on;
  if (on) goTo(index >= 0 ? { index, step: 0 } : endOf(slides.peek(), true));
  else writeAddress();
}

/** Index of the last section whose top is above the middle of the window; −1 above the first. */
export function sectionInSight(lessons: readonly { readonly id: string }[]): number {
  const middle = innerHeight / 2;
  const tops = lessons.map(({ id }) => document.getElementById(id)?.getBoundingClientRect().top ?? Number.MAX_VALUE);
  return tops.findLastIndex((top) => top < middle);
}
