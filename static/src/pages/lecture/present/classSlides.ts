/** The lecture in a class: shows the lecturer's slide, step, black screen and pointer on the pages of the followers. */

import { effect, signal } from "@preact/signals";
import { askedAs, type Classroom, classroom } from "../../../store/classroom";
import { type PageInSlide, pagesInSlides } from "../../../tools/classroom/pageInSlide";
import { followPages } from "../../../tools/classroom/pages";
import { throttled } from "../../../tools/classroom/session";
import type { ClassCommand, ClassSlide, ClassView } from "../../../wire/protocol";
import { showSection } from "../awaitedFigures";
import { LESSONS } from "../lessons";
import { pageAddress, type Slide } from "./deck/deck";
import { answerOf, answers } from "./shownAnswers";
import {
  blank,
  deck,
  paragraphsOf,
  place,
  placeHashOf,
  presenting,
  questionOf,
  sectionInSight,
  setPresenting,
  showOnly,
  slide,
  stage,
} from "./state";

/** Pages that anybody with the link may open, unlike the lab and the logs of the lecturer. */
const SHARED = /^\/shared\//;

/** What followers receive of a slide at a step: of a text the paragraphs so far, of a section its answer once shown. */
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

const SHOW_EVERY_MS = 60;
const PRESENT = "?present";

/** The lecturer's pointer as fractions of the slide; null while it is outside. */
const pointerAt = signal<readonly [number, number] | null>(null);
/** The pointer on a follower's page. */
export const shownPointer = signal<readonly [number, number] | null>(null);

const slideBox = (): DOMRect | null => document.querySelector(".slides > main")?.getBoundingClientRect() ?? null;

function watchPointer(): void {
  const leave = (): void => {
    pointerAt.value = null;
  };
  addEventListener(
    "pointermove",
    ({ clientX, clientY }) => {
      const box = presenting.peek() ? slideBox() : null;
      if (!box) return leave();
      const at = [(clientX - box.x) / box.width, (clientY - box.y) / box.height] as const;
      pointerAt.value = at.every((part) => part >= 0 && part <= 1) ? at : null;
    },
    { passive: true },
  );
  document.documentElement.addEventListener("pointerleave", leave);
  // A resting pointer refers to nothing on the next slide.
  effect(() => {
    void slide.value;
    leave();
  });
}

/** What the page inside a slide shows, which followers see instead; null if they see the slide. */
function pageWithin(now: Slide | undefined): PageInSlide | null {
  if (blank.value || !now || !("address" in now) || SHARED.test(now.address)) return null;
  return pagesInSlides.value.get(now.address) ?? null;
}

/** Send what the lecturer's page shows. */
function show(room: Classroom, sections: readonly { readonly id: string }[]): () => void {
  const send = throttled((command: ClassCommand) => room.send(command), SHOW_EVERY_MS);
  const section = signal(Math.max(0, sectionInSight(sections)));
  const onScroll = (): void => {
    section.value = Math.max(0, sectionInSight(sections));
  };
  addEventListener("scroll", onScroll, { passive: true });
  const stop = effect(() => {
    void deck.value;
    const now = presenting.value ? slide.value : undefined;
    const within = pageWithin(now)?.show;
    const shown = now
      ? shownSlide(now, place.value.step, stage.value === "answer" ? answerOf(now)?.answer : undefined)
      : null;
    if (within) {
      send({ ...within, view: { ...within.view, slide: shown } });
      return;
    }
    send({
      type: "show",
      view: {
        page: "lecture",
        hash: now ? PRESENT + placeHashOf(place.value) : `#${sections[section.value]?.id ?? ""}`,
        slide: shown,
        blank: blank.value,
        on_slide: now ? pointerAt.value : null,
      },
    });
  });
  const stopExplaining = effect(() => {
    const explained = presenting.value ? pageWithin(slide.value)?.explain : undefined;
    if (explained) room.send(explained);
  });
  // The figure of a slide shows its answer, so voting is closed with it, once; the lecturer may open it again. The
  // slide's answer reveals the counts.
  let closed: number | null = null;
  const stopRevealing = effect(() => {
    if (stage.value !== "figure") closed = null;
    const text = presenting.value ? questionOf(slide.value)?.question : undefined;
    const asked = text === undefined ? null : askedAs(text);
    if (!asked || asked.is_revealed) return;
    if (stage.value === "answer") room.send({ type: "reveal" });
    else if (stage.value === "figure" && closed !== asked.id) {
      closed = asked.id;
      if (!asked.is_closed) room.send({ type: "stop" });
    }
  });
  return () => {
    removeEventListener("scroll", onScroll);
    stop();
    stopExplaining();
    stopRevealing();
  };
}

/** Show what the lecturer's page shows. */
function follow(room: Classroom): () => void {
  let before = "";
  return effect(() => {
    const view = room.shown.value?.view;
    // Otherwise the head of the lecture would appear for a moment before the slide.
    document.documentElement.classList.toggle("is-joining", !view && !room.isOver.value && !room.isOutdated.value);
    if (view?.page !== "lecture" || !room.isFollowing.value) return;
    shownPointer.value = view.on_slide ?? null;
    const now = JSON.stringify([view.hash, view.slide]);
    if (now !== before) {
      before = now;
      goTo(view);
    }
    blank.value = view.blank ?? false;
  });
}

function goTo({ hash = "", slide: shown }: ClassView): void {
  const isSlide = hash.startsWith(PRESENT);
  if (presenting.peek() !== isSlide) setPresenting(isSlide);
  history.replaceState(null, "", location.pathname + hash);
  const only = shown ? slideOfMessage(shown) : null;
  if (only?.kind === "section") answers.value = shown?.text ? { [only.section]: { answer: shown.text } } : {};
  if (only) showOnly(only, Math.max(0, Number.parseInt(hash.split("/")[1] ?? "1", 10) - 1));
  if (!isSlide) showSection(hash.slice(1));
}

/** Take part in a class in any role. */
export function attendLecture(sections: readonly { readonly id: string }[]): void {
  followPages("lecture");
  watchPointer();
  let stop = (): void => undefined;
  effect(() => {
    stop();
    const room = classroom.value;
    stop = room === null ? () => undefined : room.isFollowed ? follow(room) : show(room, sections);
  });
}
