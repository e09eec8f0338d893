/** The slide that is shown, as a class's followers get it: nothing else of the deck, and no notes. */

import type { ClassSlide } from "../../../wire/protocol";
import { LESSONS } from "../lessons";
import { pageAddress, type Slide } from "./deck/deck";
import { paragraphsOf } from "./state";

/** Pages that who has the link may open, unlike the lab and the logs of the lecturer. */
const SHARED = /^\/shared\//;

/** What followers get of a slide at a step: of a text, the paragraphs so far; of a section, its answer once shown. */
export function shownSlide(slide: Slide, step: number, answer?: string): ClassSlide {
  const { kind } = slide;
  if (kind === "section") return { kind, section: slide.section, ...(answer === undefined ? {} : { text: answer }) };
  if (kind === "derivation") return { kind, section: slide.section };
  const { title } = slide;
  if (kind === "title") return { kind, title };
  if (kind === "text") {
    const text = paragraphsOf(slide.text).slice(0, step + 1);
    return { kind, title, text: text.join("\n\n") };
  }
  return { kind, title, ...(SHARED.test(slide.address) ? { address: slide.address } : {}) };
}

/**
 * The slide of a message; null for a section that this page does not have. A page in a slide that followers may not
 * open has no address. Throws a DeckError for an address that no slide may have.
 */
export function slideOfMessage({ kind, section, title, text, address }: ClassSlide): Slide | null {
  if (kind === "section" || kind === "derivation") {
    const known = LESSONS.find(({ id }) => id === section)?.id;
    return known ? { kind, section: known } : null;
  }
  if (kind === "title") return { kind, title: title ?? "" };
  if (kind === "text") return { kind, title: title ?? "", text: text ?? "" };
  return { kind, title: title ?? "", address: address ? pageAddress(kind, address, "The slide") : "" };
}
