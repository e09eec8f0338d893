import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { type Classroom, questionOnPage } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { toastFailure } from "../../ui/browser/attempts";
import { isTouched } from "../../ui/browser/media";
import { ask } from "../../wire/ask";
import { AnswerCard } from "./AnswerCard";
import { OutdatedPage, useRefused } from "./bars";
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
