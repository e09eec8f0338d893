import { askedAs, lecturersClass } from "../../../store/classroom";
import { Button } from "../../../ui/Button";
import { answerOf } from "./shownAnswers";
import { questionOf, slide, stage } from "./state";

/** In a class the question of a slide can be asked of everybody. */
export function ClassQuestion() {
  const room = lecturersClass.value;
  const question = questionOf(slide.value);
  if (!room || !question?.options || stage.value !== "predict" || askedAs(question.question)) return null;
  const { question: text, options } = question;
  const right = answerOf(slide.value)?.right;
  return (
    <p class="slide-ask no-print">
      <Button
        kind="primary"
        icon="people"
        onClick={() =>
          room.send({ type: "ask", text, options: [...options], ...(right === undefined ? {} : { right }) })
        }
      >
        Ask the class
      </Button>
    </p>
  );
}
