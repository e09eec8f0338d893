import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { type Classroom, endClass, openClass, questionInHeading, questionOnPage } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { toastFailure } from "../../ui/browser/attempts";
import type { ClassQuestion } from "../../wire/protocol";
import { OutdatedPage, useRefused } from "./bars";
import { Histogram } from "./Histogram";
import { codeIsShown } from "./opening";
import { PollForm } from "./PollForm";
import { PuzzleBoard } from "./PuzzleBoard";

/** Whether an address is reached only by the machine that it is opened on. */
const isLoopback = (address: string): boolean => /^(localhost|127\.[\d.]+|\[::1\])$/.test(new URL(address).hostname);

/** The code of the class, large enough for a hall: as a QR code, as letters, and as an address. */
export function CodeDialog({ isOpen }: { readonly isOpen: Signal<boolean> }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = isOpen.value;
  const found = openClass.value;
  useEffect(() => {
    if (open && found && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open, found]);
  const close = (): void => {
    isOpen.value = false;
  };
  return (
    <dialog class="class-code-dialog" ref={dialog} aria-labelledby="class-code-title" onClose={close}>
      {found && (
        <>
          <h2 id="class-code-title">Follow on your own device</h2>
          <img src={found.qr} alt={`QR code of ${found.address}`} />
          <div>
            <p>
              Scan the code, or open <b>{new URL("/join", found.address).href.replace(/^https?:\/\//, "")}</b> and type
            </p>
            <p class="class-code" role="img" aria-label={`Code ${[...found.code].join(" ")}`}>
              {found.code.slice(0, 3)} {found.code.slice(3)}
            </p>
            <p class="quiet">No account and no name. You see what the lecturer shows and can answer questions.</p>
            <Button kind="primary" onClick={close}>
              Close
            </Button>
          </div>
          {isLoopback(found.address) && (
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

/** Who drives the robot: the lecturer, or one follower. */
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

/** The question that is asked, and how many have answered; the answers once they are revealed or looked at. */
function Result({ room, question }: { readonly room: Classroom; readonly question: ClassQuestion }) {
  const present = room.state.value?.present ?? 0;
  const joinedOnly = room.state.value?.counts_joined_only ?? false;
  const isHeading = questionInHeading.value === question.text;
  const isLookedAt = room.lookedAt.value === question.id;
  return (
    <section class="class-card" aria-label="Question to the class">
      {questionOnPage.value !== question.text && (
        <>
          <h2 class={isHeading ? "visually-hidden" : ""}>{question.text}</h2>
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
