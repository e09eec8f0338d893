import { useEffect } from "preact/hooks";
import { classroom } from "../../../store/classroom";
import { Button } from "../../../ui/Button";
import { questionOf, slide, stage } from "./state";

/**
 * In a class the question of a slide can be asked of everybody. The result is revealed with the answer of the slide.
 */
export function ClassQuestion() {
  const room = classroom.value;
  const question = questionOf(slide.value);
  const asked = room?.state.value?.question ?? null;
  const isAsked = question !== undefined && asked?.text === question.question;
  const isLecturer = room !== null && !room.isFollowed;
  useEffect(() => {
    if (isLecturer && isAsked && !asked.is_revealed && stage.value === "answer") room.send({ type: "reveal" });
  }, [stage.value, isAsked]);
  if (!isLecturer || !question?.options || isAsked || stage.value !== "predict") return null;
  return (
    <p class="slide-ask no-print">
      <Button
        kind="primary"
        icon="people"
        onClick={() => {
          const { question: text, options, right } = question;
          if (options)
            room.send({ type: "ask", text, options: [...options], ...(right === undefined ? {} : { right }) });
        }}
      >
        Ask the class
      </Button>
    </p>
  );
}
