import "../style/index.css";
import "./logs/viewer.css";
import "./puzzles/puzzles.css";
import { signal } from "@preact/signals";
import { classroom, followedCode } from "../store/classroom";
import { followPages, showOther } from "../tools/classroom/pages";
import { mayPass, whyAgain } from "../wire/ask";
import { Opening } from "./logs/Opening";
import { nextPuzzle } from "./puzzles/attempt";
import { PuzzleList } from "./puzzles/PuzzleList";
import { PuzzleViewer } from "./puzzles/PuzzleViewer";
import {
  type Beginning,
  beginAttempt,
  fetchList,
  listed,
  preparing,
  rememberSolved,
  solvedPoints,
} from "./puzzles/puzzles";
import { renderPage } from "./renderPage";
import { NotOpened } from "./SessionEnded";

/** The token of a shared puzzle; null for other addresses. */
const token = /^\/puzzle\/([\w-]+)\/?$/.exec(location.pathname)?.[1] ?? null;
const hasList = token === null && followedCode === null;

/** The puzzle in the address: the name of one of the list; "" for a shared one or that of the class. */
const chosen = signal<string | null>(hasList ? new URLSearchParams(location.search).get("puzzle") : "");
const session = signal<string | null>(null);
const failure = signal<string | null>(null);
let ending: AbortController | null = null;
const RETRY_MS = 3000;

const beginning = (puzzle: string): Beginning => {
  if (followedCode !== null) return { code: followedCode };
  return token === null ? { puzzle } : { token };
};

async function nameListed(): Promise<void> {
  if (!hasList || listed.peek()) return;
  await fetchList().catch(() => undefined); // they are only named: the puzzle itself is what has to be there
}

/** Start an attempt at a puzzle. A temporary failure is shown until a later attempt succeeds. */
async function begin(name: string, isRepeated = false): Promise<void> {
  void nameListed();
  ending?.abort();
  const own = new AbortController();
  ending = own;
  session.value = null;
  if (!isRepeated) failure.value = null;
  try {
    const id = await beginAttempt(beginning(name), own.signal);
    if (own.signal.aborted) return;
    failure.value = null;
    session.value = id;
    const room = classroom.peek();
    if (room?.isFollowed) room.own.value = id;
  } catch (error) {
    if (ending !== own) return; // another puzzle was opened meanwhile
    if (own.signal.aborted) failure.value = "Opening it was cancelled.";
    else if (!mayPass(error)) failure.value = (error as Error).message;
    else {
      failure.value = whyAgain(error);
      setTimeout(() => own.signal.aborted || void begin(name, true), RETRY_MS);
    }
  }
}

function open(name: string): void {
  history.pushState(null, "", `/puzzles.html?puzzle=${encodeURIComponent(name)}`);
  chosen.value = name;
  void begin(name);
}

function close(): void {
  ending?.abort();
  history.pushState(null, "", "/puzzles.html");
  document.title = "Puzzles · Gridbloom";
  chosen.value = null;
  session.value = null;
}

addEventListener("popstate", () => {
  if (!hasList) return;
  ending?.abort();
  session.value = null;
  chosen.value = new URLSearchParams(location.search).get("puzzle");
  if (chosen.value !== null) void begin(chosen.value);
});

function Page() {
  const name = chosen.value;
  const offered = listed.value?.puzzles ?? [];
  if (name === null) return <PuzzleList onOpen={open} />;
  if (failure.value !== null && preparing.value === null) {
    return (
      <NotOpened
        title="This puzzle was not opened"
        reason={failure.value}
        onAgain={() => void begin(name)}
        back="All puzzles"
        onBack={hasList ? close : undefined}
      />
    );
  }
  if (session.value === null) {
    const awaited = offered.find((puzzle) => puzzle.name === name);
    return (
      <Opening now={preparing.value} what="Preparing the puzzle" onCancel={() => ending?.abort()}>
        {awaited && (
          <>
            <h1>{awaited.title}</h1>
            <p class="prose">{awaited.story}</p>
          </>
        )}
      </Opening>
    );
  }
  return (
    <PuzzleViewer
      key={session.value}
      session={session.value}
      onClose={hasList ? close : undefined}
      onGone={() => void begin(name)}
      next={nextPuzzle(offered, name, solvedPoints())}
      onNext={open}
      onSolved={(points) => {
        if (name) rememberSolved(name, points);
      }}
    />
  );
}

// A follower who solves a puzzle does not follow the class until "Back to the class".
const room = followedCode === null ? null : classroom.peek();
if (room) {
  room.own.value = "puzzle";
  followPages(null);
} else showOther();
if (chosen.peek() !== null) void begin(chosen.peek() ?? "");
renderPage(<Page />, { current: "puzzles", links: hasList, hasClass: hasList });
