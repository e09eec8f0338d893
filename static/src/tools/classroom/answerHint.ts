import type { Classroom } from "../../store/classroom";
import type { ClassQuestion } from "../../wire/protocol";

/** What a follower is told below a question that is asked, before its result is shown; empty after that. */
export function answerHint(question: ClassQuestion, isGiven: boolean, room: Classroom | null): string {
  if (question.is_revealed) return "";
  const number = room?.welcome.value?.number ?? 0;
  if (number > (question.last_number ?? Number.POSITIVE_INFINITY))
    return "You joined after this question was asked: your answer is not counted.";
  const what = question.options ? "Tap your answer." : "Give your answer.";
  if (!isGiven) return `${what} It is counted without your name.`;
  if (!(room?.isConnected.value ?? false)) return "Your answer is sent as soon as the class can be reached again.";
  return "Answered. You can change it until the result is shown.";
}
