import { Icon } from "../../../ui/Icon";
import type { LessonId } from "../lessons";
import { QUESTIONS } from "./questions";
import { predicted, stage } from "./state";

/** The question that a slide begins with, and the options to choose from. The figure comes after it. */
export function SlideQuestion({ id }: { id: string }) {
  const found = QUESTIONS[id as LessonId];
  if (!found || (stage.value !== "ask" && stage.value !== "predict")) return null;
  const { question, options } = found;
  const chosen = predicted.value[id];
  return (
    <div class="slide-question">
      <p class="slide-question-text">{question}</p>
      {stage.value === "predict" && options && (
        <ol class="slide-options">
          {options.map((option, i) => (
            <li key={option}>
              <button
                type="button"
                class="slide-option"
                aria-pressed={chosen === i}
                onClick={() => {
                  predicted.value = { ...predicted.peek(), [id]: i };
                }}
              >
                <span class="slide-option-letter">{String.fromCharCode(65 + i)}</span>
                {option}
                {chosen === i && (
                  <span class="slide-option-mark">
                    <Icon name="check" /> chosen
                  </span>
                )}
              </button>
            </li>
          ))}
        </ol>
      )}
    </div>
  );
}
