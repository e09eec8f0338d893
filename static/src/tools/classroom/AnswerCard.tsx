import { useSignal } from "@preact/signals";
import { type Classroom, questionInHeading } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { Variables } from "../../ui/Variables";
import type { ClassAxis } from "../../wire/protocol";
import { answerHint } from "./answerHint";
import { Histogram } from "./Histogram";
import { letterOf } from "./histogram";

/** The question that the class is asked, as a follower answers it, and its result after the reveal. */
export function AnswerCard({ room }: { readonly room: Classroom }) {
  const question = room.state.value?.question ?? null;
  if (!question) return null;
  const given = room.answer.value?.question === question.id ? room.answer.value.value : null;
  return (
    <section class="class-card" aria-label="Question to the class">
      <h2 class={questionInHeading.value === question.text ? "visually-hidden" : ""}>
        <Variables text={question.text} />
      </h2>
      {question.is_revealed ? (
        <>
          <Histogram question={question} own={given} />
          <p role="status">
            {question.answered} answered. {answerHint(question, given, room)}
          </p>
        </>
      ) : (
        <>
          {!question.is_closed && question.options && <Options room={room} options={question.options} given={given} />}
          {!question.is_closed && question.axis && (
            <Guess key={question.id} room={room} axis={question.axis} given={given} />
          )}
          <p role="status" class="quiet">
            {answerHint(question, given, room)}
          </p>
        </>
      )}
    </section>
  );
}

interface OptionsProps {
  readonly room: Classroom;
  readonly options: readonly string[];
  readonly given: number | null;
}

function Options({ room, options, given }: OptionsProps) {
  return (
    <ol class="class-options">
      {options.map((option, i) => (
        <li key={option}>
          <button type="button" class="class-option" aria-pressed={given === i} onClick={() => room.give(i)}>
            <b>{letterOf(i)}</b> {option}
          </button>
        </li>
      ))}
    </ol>
  );
}

interface GuessProps {
  readonly room: Classroom;
  readonly axis: ClassAxis;
  readonly given: number | null;
}

function Guess({ room, axis, given }: GuessProps) {
  const isWhole = Number.isInteger(axis.low) && Number.isInteger(axis.high) && axis.high - axis.low >= 10;
  const middle = (axis.low + axis.high) / 2;
  const value = useSignal(given ?? (isWhole ? Math.round(middle) : middle));
  const set = (text: string): void => {
    const wanted = Number(text);
    if (Number.isFinite(wanted)) value.value = Math.min(axis.high, Math.max(axis.low, wanted));
  };
  const step = isWhole ? 1 : (axis.high - axis.low) / 100;
  return (
    <form
      class="class-guess"
      onSubmit={(event) => {
        event.preventDefault();
        room.give(value.value);
      }}
    >
      <label>
        <span>
          My guess: <b class="number">{Number(value.value.toPrecision(4))}</b> {axis.unit}
        </span>
        <input
          type="range"
          min={axis.low}
          max={axis.high}
          step={step}
          value={value.value}
          onInput={(event) => set(event.currentTarget.value)}
        />
      </label>
      <Button kind="primary" onClick={() => room.give(value.value)}>
        {given === null ? "Answer" : "Change my answer"}
      </Button>
    </form>
  );
}
