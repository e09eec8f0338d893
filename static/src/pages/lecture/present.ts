/** The presentation mode: one figure at a time. It is in the address: `?present` and the section's anchor. */

import { signal } from "@preact/signals";
import type { Lesson } from "./lessons";

const wanted = (): boolean => new URLSearchParams(location.search).has("present");

export const presenting = signal(wanted());
export const slide = signal(0);

const address = (id: string): string => `${location.pathname}${presenting.peek() ? "?present" : ""}#${id}`;

/** Show slide `index`, limited to the first and the last. */
export function show(lessons: readonly Lesson[], index: number): void {
  const next = Math.min(lessons.length - 1, Math.max(0, index));
  slide.value = next;
  const lesson = lessons[next];
  if (lesson) history.replaceState(null, "", address(lesson.id));
}

/** Start presenting with the visible section, or end. */
export function setPresenting(lessons: readonly Lesson[], on: boolean): void {
  if (on) slide.value = Math.max(0, sectionInSight(lessons));
  presenting.value = on;
  show(lessons, slide.peek());
}

/** Index of the last section whose top is above the middle of the window; −1 above the first. */
export function sectionInSight(lessons: readonly { readonly id: string }[]): number {
  const middle = innerHeight / 2;
  const tops = lessons.map(({ id }) => document.getElementById(id)?.getBoundingClientRect().top ?? Number.MAX_VALUE);
  return tops.findLastIndex((top) => top < middle);
}

/** The slide after a key press; null for other keys. */
export function keyedSlide(key: string, shift: boolean, index: number, count: number): number | null {
  const moves: Record<string, number> = {
    ArrowRight: 1,
    ArrowLeft: -1,
    ArrowDown: 1,
    ArrowUp: -1,
    PageDown: 1,
    PageUp: -1,
    " ": shift ? -1 : 1,
    Home: -count,
    End: count,
  };
  const move = moves[key];
  return move === undefined ? null : Math.min(count - 1, Math.max(0, index + move));
}
