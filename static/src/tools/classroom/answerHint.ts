import type { Classroom } from "../../store/classroom";
import type { ClassQuestion } from "../../wire/protocol";
import { letterOf } from "./histogram";

function chosen({ options, axis }: ClassQuestion, given: number | null): string {
  if (given === null) return "You gave no answer.";
  if (options) return `You chose ${letterOf(given)}: ${options[given] ?? ""}`;
  return `You answered ${Number(given.toPrecision(4))} ${axis?.unit ?? ""}`.trim();
}

/** What a follower is told below a question that is asked, before its result is shown; empty after that. */
export function answerHint(question: ClassQuestion, given: number | null, room: Classroom | null): string {
  if (question.is_revealed) return "";
  if (question.is_closed) return `Voting is closed. ${chosen(question, given)}`;
  const number = room?.welcome.value?.number ?? 0;
  if (number > (question.last_number ?? Number.POSITIVE_INFINITY))
    return "You joined after this question was asked: your answer is not counted.";
  const what = question.options ? "Tap your answer." : "Give your answer.";
  if (given === null) return `${what} It is counted without your name.`;
  if (!(room?.isConnected.value ?? false)) return "Your answer is sent as soon as the class can be reached again.";
  return "Answered. You can change it until voting is closed.";
}
