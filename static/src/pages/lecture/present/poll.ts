/** The question of the present slide or of the class, as the speaker's window shows it. */

import { classroom, lecturersClass } from "../../../store/classroom";
import { answerOf } from "./shownAnswers";
import { questionOf, slide, stage } from "./state";

/** The actions that are possible now. */
export type PollAct = "ask" | "stop" | "reopen" | "reveal";

export interface Poll {
  readonly text: string;
  /** The options with their counts; null while it is not asked. */
  readonly options: readonly { readonly text: string; readonly count: number | null; readonly isRight: boolean }[];
  /** "3 of 12 answered", or the reason why nobody can answer. */
  readonly status: string;
  readonly acts: readonly PollAct[];
}

/** The question of the slide, before it is asked. */
function ofSlide(): Poll | null {
  const now = slide.value;
  const question = questionOf(now);
  if (!question?.options) return null;
  const right = answerOf(now)?.right;
  const room = lecturersClass.value;
  const canAsk = room?.isConnected.value && (stage.value === "ask" || stage.value === "predict");
  return {
    text: question.question,
    options: question.options.map((text, i) => ({ text, count: null, isRight: i === right })),
    status: room ? "Not asked" : "No class is open",
    acts: canAsk ? ["ask"] : [],
  };
}

/**
 * The question shown to the speaker; null for none. Unlike the page with the slides it has the counts and the right
 * answer.
 */
export function pollOf(): Poll | null {
  const state = lecturersClass.value?.state.value;
  const asked = state?.question;
  const own = ofSlide();
  if (!state || !asked || (asked.is_closed && own && own.text !== asked.text)) return own;
  const { right, counts } = asked;
  const axis = asked.options ? [] : [right === null ? "" : `, right: ${right} ${asked.axis?.unit ?? ""}`.trimEnd()];
  const voting = asked.is_revealed ? "the result is shown" : asked.is_closed ? "voting is closed" : "voting is open";
  const all = Math.max(state.present, asked.answered);
  return {
    text: asked.text,
    options: (asked.options ?? []).map((text, i) => ({ text, count: counts?.[i] ?? 0, isRight: i === right })),
    status: `${asked.answered} of ${all} answered, ${voting}${axis.join("")}`,
    acts: asked.is_revealed ? [] : asked.is_closed ? ["reveal", "reopen"] : ["stop", "reveal"],
  };
}

/** Carry out an action of the speaker's window. */
export function actOnPoll(act: PollAct): void {
  const room = lecturersClass.peek();
  if (!room || classroom.peek()?.isFollowed) return;
  if (act === "ask") askSlide();
  else if (act === "reveal") room.send({ type: act });
  else room.send({ type: "stop", value: act === "stop" });
}

/** Ask the class the question of the present slide. */
export function askSlide(): void {
  const now = slide.peek();
  const question = questionOf(now);
  if (!question?.options) return;
  const right = answerOf(now)?.right;
  const asked = { text: question.question, options: [...question.options] };
  lecturersClass.peek()?.send({ type: "ask", ...asked, ...(right === undefined ? {} : { right }) });
}
