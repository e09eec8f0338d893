import type { Classroom } from "../../store/classroom";
import type { ClassQuestion } from "../../wire/protocol";
import { letterOf } from "./histogram";

const plain = (value: number): string => String(Number(value.toPrecision(6))); // differences have rounding errors

function chosen({ options, axis }: ClassQuestion, given: number | null): string {
  if (given === null) return "You gave no answer.";
  if (options) return `You chose ${letterOf(given)}: ${options[given] ?? ""}`;
  return `You answered ${plain(given)} ${axis?.unit ?? ""}`.trim();
}

/** Whether the answer was right, and the right answer, if the question has one. */
function verdict({ options, axis, right }: ClassQuestion, given: number | null): string {
  if (right === null) return "";
  if (options) {
    if (given === right) return `${letterOf(given)} is right.`;
    const answer = `answer is ${letterOf(right)}: ${options[right] ?? ""}`;
    return given === null ? `The ${answer}` : `${letterOf(given)} is wrong; the ${answer}`;
  }
  const unit = axis?.unit ? ` ${axis.unit}` : "";
  const result = `The result is ${plain(right)}${unit}.`;
  if (given === null) return result;
  const off = Number(plain(given - right));
  return off === 0
    ? "Exactly right."
    : `${result} Yours was ${plain(Math.abs(off))}${unit} too ${off > 0 ? "high" : "low"}.`;
}

/** The hint for a follower below a question: how to answer it, or the right answer after its reveal. */
export function answerHint(question: ClassQuestion, given: number | null, room: Classroom | null): string {
  if (question.is_revealed) return verdict(question, given);
  if (question.is_closed) return `Voting is closed. ${chosen(question, given)}`;
  const number = room?.welcome.value?.number ?? 0;
  if (number > (question.last_number ?? Number.POSITIVE_INFINITY))
    return "You joined after this question was asked: your answer is not counted.";
  const what = question.options ? "Tap your answer." : "Give your answer.";
  if (given === null) return `${what} It is counted without your name.`;
  if (!(room?.isConnected.value ?? false)) return "Your answer is sent as soon as the class can be reached again.";
  return "Answered. You can change it until voting is closed.";
}
