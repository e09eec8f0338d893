/**
 * The answers that this page has: the lecturer and a reader have all, a follower has the one that the lecturer shows.
 */

import { signal } from "@preact/signals";
import { followedCode } from "../../../store/classroom";
import type { LessonId } from "../lessons";
import type { Slide } from "./deck/deck";
import type { Answer } from "./questions";

const RETRY_MS = 3000;

export const answers = signal<Partial<Record<LessonId, Answer>>>({});

export const answerOf = (of: Slide | undefined): Answer | undefined =>
  of?.kind === "section" ? answers.value[of.section] : undefined;

const notes = signal<Readonly<Record<string, string>>>({});

/** The default notes of a slide that does not belong to a section. */
export const otherNotes = (of: Slide | undefined): string | undefined =>
  of && notes.value[of.kind === "derivation" ? `${of.section}-derivation` : of.kind];

/** Fetch the answers, repeatedly while the server does not answer; not for a follower of a class. */
export async function fetchAnswers(): Promise<void> {
  if (followedCode !== null) return;
  try {
    const fetched = await import("./answers");
    answers.value = fetched.ANSWERS;
    notes.value = fetched.OTHER_NOTES;
  } catch {
    setTimeout(() => void fetchAnswers(), RETRY_MS);
  }
}
