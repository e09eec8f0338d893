import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import {
  type Classroom,
  endClass,
  lecturersClass,
  openClass,
  questionInHeading,
  questionOnPage,
} from "../../store/classroom";
import { Button } from "../../ui/Button";
import { selected } from "../../ui/bound";
import { toastFailure } from "../../ui/browser/attempts";
import { Choice } from "../../ui/Choice";
import { toast } from "../../ui/Toast";
import { Variables } from "../../ui/text/Variables";
import { ask } from "../../wire/ask";
import type { ClassPuzzle, ClassQuestion, ClassSolver } from "../../wire/protocol";
import { OutdatedPage, useRefused } from "./bars";
import { Histogram } from "./Histogram";
import { letterOf } from "./histogram";
import { codeIsShown } from "./opening";

const percent = (share: number): string => `${Math.floor(100 * share)} %`;

function described(solver: ClassSolver): string {
  if (solver.is_solved) return `solved, ${solver.points} points`;
  return `${solver.is_named ? "cause named, " : ""}repaired ${percent(solver.repair)}`;
}

const sign = (solver: ClassSolver): string => (solver.is_solved ? "✓" : solver.is_named ? "½" : "·");

/**
 * The progress of each follower with the class's puzzle, for the lecturer: numbers, no names. The numbers can be
 * unfolded, so that the board takes one line of the page.
 */
function PuzzleBoard({ room, puzzle }: { readonly room: Classroom; readonly puzzle: ClassPuzzle }) {
  const isOpen = useSignal(false);
  const close = async (): Promise<void> => {
    await ask("DELETE /api/classes/{code}/puzzle", { code: room.code }).catch(() =>
      toast("The puzzle could not be ended: the server does not answer.", "error"),
    );
  };
  return (
    <section class="class-card" aria-label="Puzzle of the class">
      <div class="class-line">
        <h2>{puzzle.title}</h2>
        <p role="status">
          {puzzle.solved} of {puzzle.begun} solved
        </p>
        <div class="actions">
          <Button
            pressed={isOpen.value}
            onClick={() => {
              isOpen.value = !isOpen.value;
            }}
          >
            Each follower
          </Button>
          {lecturersClass.value && <Button onClick={() => void close()}>End the puzzle</Button>}
        </div>
      </div>
      {isOpen.value && <Numbers puzzle={puzzle} />}
    </section>
  );
}

function Numbers({ puzzle }: { readonly puzzle: ClassPuzzle }) {
  if (puzzle.begun === 0)
    return <p class="quiet">Nobody has begun yet. Followers have a button at the bottom of their page.</p>;
  return (
    <>
      <ul class="class-board">
        {puzzle.board.map((solver) => (
          <li key={solver.number} class={solver.is_solved ? "is-solved" : solver.is_named ? "is-named" : ""}>
            <span aria-hidden="true">{sign(solver)}</span> <b class="number">{solver.number}</b>
            <span class="class-board-bar" aria-hidden="true">
              <i style={`width: ${100 * (solver.is_solved ? 1 : solver.repair)}%`} />
            </span>
            <span class="visually-hidden">{described(solver)}</span>
          </li>
        ))}
      </ul>
      <p class="quiet class-board-legend">
        “·” begun, “½” cause named, “✓” solved; the bar is the repair. The numbers are those of the followers.
      </p>
    </>
  );
}

const MOST_OPTIONS = 8;

/** A number as typed, with a point or a comma; null for an empty field, NaN for an invalid number. */
const numberIn = (text: string): number | null => (text.trim() === "" ? null : Number(text.trim().replace(",", ".")));

/** The index of the right option among those that are not empty; null for none. */
function rightAmong(options: readonly string[], right: number): number | null {
  if (!options[right]?.trim()) return null;
  return options.slice(0, right).filter((option) => option.trim()).length;
}

/** A form for an ad hoc question: options to choose from, or a number to guess. */
export function PollForm({ room, isOpen }: { readonly room: Classroom; readonly isOpen: Signal<boolean> }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const kind = useSignal("options");
  const text = useSignal("");
  const options = useSignal<readonly string[]>(["Yes", "No"]);
  const low = useSignal("0");
  const high = useSignal("100");
  const unit = useSignal("");
  /** The right one of the options, −1 for none; and the right number, empty for none. */
  const rightOption = useSignal(-1);
  const rightNumber = useSignal("");
  const open = isOpen.value;
  useEffect(() => {
    if (open && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open]);
  const given = options.value.map((option) => option.trim()).filter(Boolean);
  const isAxis = kind.value === "number";
  const from = numberIn(low.value);
  const to = numberIn(high.value);
  const right = isAxis ? numberIn(rightNumber.value) : rightAmong(options.value, rightOption.value);
  const isReady =
    room.isConnected.value &&
    text.value.trim() !== "" &&
    (isAxis ? from !== null && to !== null && from < to && !Number.isNaN(right) : given.length >= 2);
  const submit = (): void => {
    if (!isReady) return;
    const axis = { low: from ?? 0, high: to ?? 0, unit: unit.value.trim() };
    const known = right === null ? {} : { right };
    room.send({ type: "ask", text: text.value, ...(isAxis ? { axis } : { options: given }), ...known });
    isOpen.value = false;
    text.value = rightNumber.value = "";
    rightOption.value = -1;
  };
  const change = (at: number, value: string): void => {
    options.value = options.value.map((option, i) => (i === at ? value : option));
  };
  return (
    <dialog
      class="dialog class-poll"
      ref={dialog}
      aria-labelledby="class-poll-title"
      onClose={() => {
        isOpen.value = false;
      }}
    >
      <h2 id="class-poll-title">Ask the class</h2>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          submit();
        }}
      >
        <label class="field">
          <span class="field-label">Question</span>
          <input
            class="field-text"
            maxLength={300}
            value={text.value}
            onInput={(event) => {
              text.value = event.currentTarget.value;
            }}
          />
        </label>
        <Choice
          label="Answer"
          options={[
            { value: "options", label: "One of several" },
            { value: "number", label: "A number" },
          ]}
          {...selected(kind)}
        />
        {isAxis ? (
          <div class="class-axis-fields">
            {(
              [
                ["From", low],
                ["To", high],
                ["Unit", unit],
                ["Right (if any)", rightNumber],
              ] as const
            ).map(([label, value]) => (
              <label class="field" key={label}>
                <span class="field-label">{label}</span>
                <input
                  class="field-text"
                  inputMode={label === "Unit" ? "text" : "decimal"}
                  maxLength={30}
                  value={value.value}
                  onInput={(event) => {
                    value.value = event.currentTarget.value;
                  }}
                />
              </label>
            ))}
          </div>
        ) : (
          <>
            {options.value.map((option, i) => (
              <div class="class-poll-option" key={i}>
                <label class="field">
                  <span class="field-label">Option {letterOf(i)}</span>
                  <input
                    class="field-text"
                    maxLength={300}
                    value={option}
                    onInput={(event) => change(i, event.currentTarget.value)}
                  />
                </label>
                <Button
                  pressed={rightOption.value === i}
                  icon="check"
                  label={`Mark ${letterOf(i)} as right`}
                  onClick={() => {
                    rightOption.value = rightOption.peek() === i ? -1 : i;
                  }}
                />
              </div>
            ))}
            {options.value.length < MOST_OPTIONS && (
              <Button
                kind="quiet"
                icon="plus"
                onClick={() => {
                  options.value = [...options.value, ""];
                }}
              >
                Another option
              </Button>
            )}
          </>
        )}
        <p class="quiet">
          {isAxis ? "The right number is" : "A right option, marked with ✓, is"} shown to the class with the result. One
          answer is counted for each browser that has joined.
        </p>
        {!room.isConnected.value && <p role="status">The class cannot be reached now. Connecting …</p>}
        <div class="dialog-actions">
          <Button
            onClick={() => {
              isOpen.value = false;
            }}
          >
            Cancel
          </Button>
          <Button kind="primary" disabled={!isReady} onClick={submit}>
            Ask
          </Button>
        </div>
      </form>
    </dialog>
  );
}

/** Whether an address is reachable only from the machine on which it is opened. */
const isLoopback = (address: string): boolean => /^(localhost|127\.[\d.]+|\[::1\])$/.test(new URL(address).hostname);

/** The code of the class, large enough for a hall: as a QR code, as letters, and as an address. */
export function CodeDialog({ isOpen }: { readonly isOpen: Signal<boolean> }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = isOpen.value;
  const opened = openClass.value;
  useEffect(() => {
    if (open && opened && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open, opened]);
  const close = (): void => {
    isOpen.value = false;
  };
  return (
    <dialog class="class-code-dialog" ref={dialog} aria-labelledby="class-code-title" onClose={close}>
      {opened && (
        <>
          <h2 id="class-code-title">Follow on your own device</h2>
          <img src={opened.qr} alt={`QR code of ${opened.address}`} />
          <div>
            <p>
              Scan the code, or open <b>{new URL("/join", opened.address).href.replace(/^https?:\/\//, "")}</b> and type
            </p>
            <p class="class-code" role="img" aria-label={`Code ${[...opened.code].join(" ")}`}>
              {opened.code.slice(0, 3)} {opened.code.slice(3)}
            </p>
            <p class="quiet">No account and no name. You see what the lecturer shows and can answer questions.</p>
            <Button kind="primary" onClick={close}>
              Close
            </Button>
          </div>
          {isLoopback(opened.address) && (
            <p class="class-unreachable" role="alert">
              Only this computer reaches this address. For other devices, start the service with{" "}
              <code>gridbloom serve --class</code>.
            </p>
          )}
        </>
      )}
    </dialog>
  );
}

/** The lecturer's controls of the class, on every page. */
export function LecturerBar({ room }: { readonly room: Classroom }) {
  const isPolling = useSignal(false);
  const isEnding = useSignal(false);
  useRefused(room);
  const state = room.state.value;
  const question = room.question.value;
  const end = async (): Promise<void> => {
    isEnding.value = false;
    await toastFailure(endClass);
  };
  if (room.isOutdated.value) return <OutdatedPage />;
  if (room.isOver.value)
    return (
      <aside class="class-bar-box no-print" aria-label="Class">
        <div class="class-line">
          <p role="status">
            Class <b class="class-code-small">{room.code}</b> has ended, or its server was stopped.
          </p>
          <div class="actions">
            <Button onClick={() => void end()}>Close</Button>
          </div>
        </div>
      </aside>
    );
  return (
    <aside class="class-bar-box no-print" aria-label="Class">
      {state?.puzzle && <PuzzleBoard room={room} puzzle={state.puzzle} />}
      {question && <Result room={room} question={question} />}
      <div class="class-line">
        <p role="status">
          <span class={`class-dot ${room.isConnected.value ? "is-live" : ""}`} aria-hidden="true" />
          Class <b class="class-code-small">{room.code}</b> ·{" "}
          {room.isConnected.value ? `${state?.present ?? 0} here` : "connecting …"}
          {state?.is_locked && " · locked: nobody else can join"}
        </p>
        <div class="actions">
          <Button
            onClick={() => {
              codeIsShown.value = true;
            }}
          >
            Show the code
          </Button>
          <Button
            disabled={!room.isConnected.value}
            onClick={() => {
              isPolling.value = true;
            }}
          >
            Ask
          </Button>
          <Robot room={room} />
          <Button
            pressed={state?.is_locked ?? false}
            disabled={!room.isConnected.value}
            label="Lock: nobody else can join"
            onClick={() => room.send({ type: "lock", value: !state?.is_locked })}
          >
            Lock
          </Button>
          {isEnding.value ? (
            <>
              {openClass.value && (
                <Button icon="download" href={openClass.value.results} download>
                  Results (CSV)
                </Button>
              )}
              <Button kind="danger" onClick={() => void end()}>
                End and delete results
              </Button>
              <Button
                kind="quiet"
                onClick={() => {
                  isEnding.value = false;
                }}
              >
                Continue the class
              </Button>
            </>
          ) : (
            <Button
              onClick={() => {
                isEnding.value = true;
              }}
            >
              End …
            </Button>
          )}
        </div>
      </div>
      <CodeDialog isOpen={codeIsShown} />
      <PollForm room={room} isOpen={isPolling} />
    </aside>
  );
}

/** The driver of the robot: the lecturer, or one follower. */
function Robot({ room }: { readonly room: Classroom }) {
  const state = room.state.value;
  if (!state || (state.hands.length === 0 && state.driver === null)) return null;
  return state.driver === null ? (
    <label class="class-hands">
      <span class="visually-hidden">Hand over the robot</span>
      <select
        class="select"
        value=""
        onChange={(event) => {
          const number = Number(event.currentTarget.value);
          event.currentTarget.value = "";
          if (number) room.send({ type: "hand", number });
        }}
      >
        <option value="">
          Hand over the robot ({state.hands.length} {state.hands.length === 1 ? "request" : "requests"})
        </option>
        {state.hands.map((number) => (
          <option key={number} value={number}>
            Number {number}
          </option>
        ))}
      </select>
    </label>
  ) : (
    <Button icon="robot" onClick={() => room.send({ type: "hand" })}>
      Take the robot back from number {state.driver}
    </Button>
  );
}

/** The current question, and the number of answers; the answers themselves once they are revealed or requested. */
function Result({ room, question }: { readonly room: Classroom; readonly question: ClassQuestion }) {
  const present = room.state.value?.present ?? 0;
  const joinedOnly = room.state.value?.counts_joined_only ?? false;
  const isHeading = questionInHeading.value === question.text;
  const isLookedAt = room.lookedAt.value === question.id;
  return (
    <section class="class-card" aria-label="Question to the class">
      {questionOnPage.value !== question.text && (
        <>
          <h2 class={isHeading ? "visually-hidden" : ""}>
            <Variables text={question.text} />
          </h2>
          {(!isHeading || question.counts) && <Histogram question={question} own={null} />}
        </>
      )}
      <div class="class-line">
        <p role="status">
          {question.answered} of {Math.max(present, question.answered)} answered
          {question.is_closed && !question.is_revealed && " · voting is closed"}
          {joinedOnly && <span class="quiet"> · only those who had joined before</span>}
        </p>
        <div class="actions">
          <Button
            pressed={joinedOnly}
            label="Joined before: count only followers who had joined before the question, one answer for each number"
            onClick={() => room.send({ type: "count", joined_only: !joinedOnly })}
          >
            Joined before
          </Button>
          {!question.is_revealed && (
            <Button
              disabled={!room.isConnected.value}
              onClick={() => room.send({ type: "stop", value: !question.is_closed })}
            >
              {question.is_closed ? "Open voting again" : "Close voting"}
            </Button>
          )}
          {!question.is_revealed && (
            <>
              <Button
                label={isLookedAt ? "Hide answers" : "Show answers on this screen only"}
                onClick={() => {
                  room.lookedAt.value = isLookedAt ? null : question.id;
                }}
              >
                {isLookedAt ? "Hide answers" : "Show answers"}
              </Button>
              <Button kind="primary" disabled={!room.isConnected.value} onClick={() => room.send({ type: "reveal" })}>
                Show the result
              </Button>
            </>
          )}
          <Button disabled={!room.isConnected.value} onClick={() => room.send({ type: "close" })}>
            Remove the question
          </Button>
        </div>
      </div>
    </section>
  );
}
