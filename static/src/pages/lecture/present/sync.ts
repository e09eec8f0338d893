/** Connects the window with the slides and the speaker's window by a channel of the browser, without a server. */

import { effect } from "@preact/signals";
import { act } from "./acts";
import { type Slide, titleOf } from "./deck/deck";
import type { Act } from "./keys";
import { actOnPoll, type Poll, type PollAct, pollOf } from "./poll";
import { answerOf, otherNotes } from "./shownAnswers";
import { blank, deck, hashOf, type Place, place, slides, stepped } from "./state";

/** The state of the speaker's window. */
export interface SpeakerState {
  readonly title: string;
  readonly notes: string;
  /** The fragments of the present slide and of the slide after the next step; null at the end. */
  readonly now: string;
  readonly next: string | null;
  readonly number: number;
  readonly total: number;
  readonly blank: boolean;
  /** Planned minutes from the start to the end of this slide and of the last one; null without a plan. */
  readonly plan: { readonly until: number; readonly total: number } | null;
  readonly poll: Poll | null;
}

type Message =
  | { readonly speakerState: SpeakerState }
  | { readonly act: Act }
  | { readonly poll: PollAct }
  | { readonly hello: true };

const named = (id: string): BroadcastChannel => new BroadcastChannel(`gridbloom-slides-${id}`);

const notesOf = (of: Slide | undefined): string => of?.notes ?? answerOf(of)?.notes ?? otherNotes(of) ?? "";

/** The plan at shown slide `number`, from 1. */
function planOf(shown: readonly Slide[], number: number): SpeakerState["plan"] {
  const sum = (of: readonly Slide[]): number => of.reduce((minutes, slide) => minutes + (slide.minutes ?? 0), 0);
  const total = sum(shown);
  return total > 0 ? { until: sum(shown.slice(0, number)), total } : null;
}

function speakerState(at: Place): SpeakerState {
  const list = slides.peek();
  const next = stepped(at, 1, false, list);
  const now = list[at.index];
  const isShown = (slide: Slide, i: number): boolean => i === at.index || !slide.hidden;
  const shown = list.filter(isShown);
  const number = list.slice(0, at.index + 1).filter(isShown).length;
  return {
    title: now ? titleOf(now) : "",
    notes: notesOf(now),
    now: hashOf(at),
    next: next.index === at.index && next.step === at.step ? null : hashOf(next),
    number,
    total: shown.length,
    blank: blank.peek(),
    plan: planOf(shown, number),
    poll: pollOf(),
  };
}

let channel: BroadcastChannel | null = null;
const id = Math.random().toString(36).slice(2, 10);

/** Open the speaker's window. It follows the slides, and its keys control them. */
export function openSpeaker(): boolean {
  if (!channel) {
    const opened = named(id);
    channel = opened;
    const tell = (): void => opened.postMessage({ speakerState: speakerState(place.peek()) } satisfies Message);
    opened.onmessage = ({ data }: MessageEvent<Message>) => {
      if ("act" in data) act(data.act);
      else if ("poll" in data) actOnPoll(data.poll);
      else if ("hello" in data) tell();
    };
    effect(() => {
      void [place.value, blank.value, deck.value, pollOf()];
      tell();
    });
  }
  return window.open(`/lecture.html?speaker=${id}`, `gridbloom-speaker-${id}`, "popup,width=1280,height=720") !== null;
}

/** The actions of the speaker's window. */
export interface Remote {
  readonly act: (act: Act) => void;
  readonly poll: (act: PollAct) => void;
}

/** In the speaker's window: follow the slides of `id`. The returned functions send the requests of keys and buttons. */
export function followSlides(id: string, show: (speakerState: SpeakerState) => void): Remote {
  const opened = named(id);
  opened.onmessage = ({ data }: MessageEvent<Message>) => {
    if ("speakerState" in data) show(data.speakerState);
  };
  opened.postMessage({ hello: true } satisfies Message);
  return {
    act: (act) => opened.postMessage({ act } satisfies Message),
    poll: (poll) => opened.postMessage({ poll } satisfies Message),
  };
}
