import { useLayoutEffect } from "preact/hooks";
import { askedAs, classroom, lecturersClass, showsAnswers } from "../../../store/classroom";
import { answerHint } from "../../../tools/classroom/answerHint";
import { barsOf, letterOf } from "../../../tools/classroom/histogram";
import { Button } from "../../../ui/Button";
import { Icon } from "../../../ui/Icon";
import { Variables } from "../../../ui/text/Variables";
import type { LessonId } from "../lessons";
import { askSlide } from "./poll";
import { QUESTIONS } from "./questions";
import { predicted, presenting, questionOf, slide, stage } from "./state";

/** In a class, everybody can be asked the question of a slide. */
function ClassQuestion() {
  const room = lecturersClass.value;
  const question = questionOf(slide.value);
  if (!room || !question?.options || stage.value !== "predict" || askedAs(question.question)) return null;
  return (
    <p class="slide-ask no-print">
      <Button kind="primary" icon="people" onClick={askSlide}>
        Ask the class
      </Button>
    </p>
  );
}

/**
 * The question at the start of a slide with its options; the figure follows. In a class the followers choose the
 * options, and each option shows its count.
 */
export function SlideQuestion({ id }: { id: string }) {
  const question = QUESTIONS[id as LessonId];
  const isShown = question !== undefined && (stage.value === "ask" || stage.value === "predict");
  const hasOptions = isShown && stage.value === "predict" && question.options !== undefined;
  const text = question?.question ?? "";
  // before the options are painted, so that the class's line never shows them as well
  useLayoutEffect(() => {
    if (hasOptions && presenting.value) return showsAnswers(text);
    return;
  }, [hasOptions, text]);
  if (!isShown) return null;
  return (
    <div class="slide-question">
      <p class="slide-question-text">
        <Variables text={text} />
      </p>
      {hasOptions && <SlideOptions id={id} text={text} options={question.options ?? []} />}
      <ClassQuestion />
    </div>
  );
}

interface SlideOptionsProps {
  readonly id: string;
  readonly text: string;
  readonly options: readonly string[];
}

function SlideOptions({ id, text, options }: SlideOptionsProps) {
  const asked = askedAs(text);
  const room = classroom.value;
  const answer = room?.answer.value;
  const given = asked && answer?.question === asked.id ? answer.value : undefined;
  const chosen = asked ? given : predicted.value[id];
  const bars = asked ? barsOf(asked) : [];
  const isFollowed = room?.isFollowed ?? false;
  const choose = (option: number): void => {
    if (!asked) predicted.value = { ...predicted.peek(), [id]: option };
    else if (room?.isFollowed) room.give(option);
  };
  return (
    <>
      <ol class="slide-options">
        {options.map((option, i) => (
          <li key={option}>
            <button
              type="button"
              class="slide-option"
              aria-pressed={chosen === i}
              disabled={asked ? asked.is_closed : isFollowed}
              onClick={() => choose(i)}
            >
              {bars[i] && (
                <span
                  class={`slide-option-bar ${bars[i].isRight ? "is-right" : ""}`}
                  style={`width: ${100 * bars[i].length}%`}
                  aria-hidden="true"
                />
              )}
              <span class="slide-option-letter">{letterOf(i)}</span>
              <span>
                <Variables text={option} />
              </span>
              <span class="slide-option-mark">
                {chosen === i && (
                  <>
                    <Icon name="check" /> chosen
                  </>
                )}{" "}
                {bars[i]?.isRight && <b class="slide-option-right">right</b>}{" "}
                {bars[i] && (
                  <>
                    <b class="number">{bars[i].count}</b>
                    <span class="visually-hidden">{bars[i].count === 1 ? " answer" : " answers"}</span>
                  </>
                )}
              </span>
            </button>
          </li>
        ))}
      </ol>
      {isFollowed && (
        <p class="slide-ask" role="status">
          {asked ? answerHint(asked, given ?? null, room) : "Wait for the question."}
        </p>
      )}
    </>
  );
}
