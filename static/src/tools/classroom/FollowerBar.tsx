import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { type Classroom, questionInHeading, questionOnPage } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { toastFailure } from "../../ui/browser/attempts";
import { isTouched } from "../../ui/browser/media";
import { Variables } from "../../ui/text/Variables";
import { ask } from "../../wire/ask";
import type { ClassAxis } from "../../wire/protocol";
import { answerHint } from "./answerHint";
import { OutdatedPage, useRefused } from "./bars";
import { Histogram } from "./Histogram";
import { letterOf } from "./histogram";
import { loadingPage } from "./pages";

/** Begin a session with the current state of the lecturer's. */
async function fork(room: Classroom): Promise<void> {
  room.own.value = (await ask("POST /api/classes/{code}/sessions", { code: room.code })).id;
}

/** The follower's line about the class on every page: the state, the question, and a button for an own world. */
export function FollowerBar({ room }: { readonly room: Classroom }) {
  const isForking = useSignal(false);
  const hasTouched = useSignal(false);
  useEffect(() => {
    // Controls that cannot be used are inert; a click on them goes to the view around them.
    const touched = ({ target }: MouseEvent): void => {
      hasTouched.value = target instanceof Element && target.closest(".is-following") !== null;
    };
    document.addEventListener("click", touched);
    return () => document.removeEventListener("click", touched);
  }, []);
  useRefused(room);
  const state = room.state.value;
  if (room.isOutdated.value) return <OutdatedPage />;
  if (room.isOver.value)
    return (
      <aside class="class-bar-box" aria-label="Class">
        <div class="class-line">
          <p role="status">
            The class has ended. <span class="quiet">What you see no longer changes.</span>
          </p>
          <div class="actions">
            <Button href="/join">Join another class</Button>
          </div>
        </div>
      </aside>
    );
  const isOwn = room.own.value !== null;
  const canFork = (room.shown.value?.stage ?? 0) > 0;
  const tryOut = async (): Promise<void> => {
    isForking.value = true;
    await toastFailure(() => fork(room));
    isForking.value = false;
  };
  const asks = room.asksForRobot.value;
  return (
    <aside class={`class-bar-box ${isOwn ? "is-own" : ""}`} aria-label="Class">
      {questionOnPage.value !== state?.question?.text && <AnswerCard room={room} />}
      <div class="class-line">
        <p role="status">
          <span class={`class-dot ${room.isConnected.value ? "is-live" : ""}`} aria-hidden="true" />
          {hasTouched.value && canFork && !isOwn && !room.drives.value
            ? "The lecturer controls this. “Try it yourself” gives you a copy."
            : described(room, isOwn)}
          {state && (
            <span class="quiet">
              {" "}
              {state.present} here · you are number {room.welcome.value?.number ?? "…"}
            </span>
          )}
        </p>
        <div class="actions">
          {state?.puzzle && !isPuzzlePage && (
            <Button kind="primary" href={`/class/${room.code}/puzzles.html`}>
              Solve the puzzle
            </Button>
          )}
          {isOwn ? (
            <Button
              kind="primary"
              icon="back"
              onClick={() => {
                room.own.value = null;
              }}
            >
              Back to the class
            </Button>
          ) : (
            canFork && (
              <>
                <Button kind="primary" disabled={isForking.value} onClick={() => void tryOut()}>
                  {isForking.value ? "Copying …" : "Try it yourself"}
                </Button>
                {!room.drives.value && hasRobot(room) && (
                  <Button pressed={asks} icon="robot" onClick={() => room.raise(!asks)}>
                    {asks ? "Asked for the robot" : "Ask for the robot"}
                  </Button>
                )}
              </>
            )
          )}
        </div>
      </div>
    </aside>
  );
}

/** Whether the lecturer shows a world whose robot can be driven. */
const hasRobot = (room: Classroom): boolean => room.shown.value?.view.page !== "logs";

const isPuzzlePage = location.pathname.endsWith("/puzzles.html");

function described(room: Classroom, isOwn: boolean): string {
  if (!room.isConnected.value) return "Connecting to the class …";
  if (isPuzzlePage) return "The puzzle of the class.";
  if (isOwn) return hasRobot(room) ? "Your own world." : "Your own copy of the map.";
  if (loadingPage.value !== null) return "Loading the page that the lecturer has opened …";
  if (room.state.value?.is_lecturer_away) return "The lecturer is away.";
  if (room.drives.value)
    return isTouched()
      ? "You drive the robot: drag it, or tap a place on a map."
      : "You drive the robot: drag it, click a place on a map, or use the arrow keys.";
  if (room.shown.value?.view.page === "other") return "Waiting for the lecturer.";
  return "Following the lecturer.";
}

/** The class's question as a follower answers it, and its result after the reveal. */
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
