import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { lecturersClass } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { toastFailure } from "../../ui/browser/attempts";
import { isDark } from "../../ui/browser/theme";
import { confirm } from "../../ui/Dialog";
import { Icon } from "../../ui/Icon";
import { toast } from "../../ui/Toast";
import { addressOf } from "../../wire/ask";
import type { MadePuzzleAnswer, OfferedPuzzle } from "../../wire/http";
import { fetchList, giveToClass, listed, removePuzzle, solvedPoints } from "./puzzles";

/** The initial map of an attempt at a puzzle. */
function PuzzlePicture({ puzzle }: { readonly puzzle: OfferedPuzzle }) {
  const state = useSignal<"awaited" | "shown" | "failed">("awaited");
  return (
    <div class={`card-picture ${state.value}`}>
      {state.value !== "shown" && <Icon name="map" />}
      {state.value !== "failed" && (
        <img
          src={addressOf("GET /api/puzzles/{puzzle}/map.png", { puzzle: puzzle.name }, { dark: isDark.value })}
          alt={`Map of ${puzzle.title}`}
          loading="lazy"
          decoding="async"
          onLoad={() => {
            state.value = "shown";
          }}
          onError={() => {
            state.value = "failed";
          }}
        />
      )}
    </div>
  );
}

const LEVELS: Readonly<Record<number, string>> = { 1: "Level 1", 2: "Level 2", 3: "Level 3" };

async function give(puzzle: string): Promise<void> {
  const room = lecturersClass.peek();
  if (!room) return;
  await toastFailure(async () => {
    await giveToClass(room.code, puzzle);
    toast("The class can begin. The board is at the bottom of the page.");
  });
}

/** All puzzles by level, and those made by the visitor. */
export function PuzzleList({ onOpen }: { readonly onOpen: (name: string) => void }) {
  const failure = useSignal<string | null>(null);
  const load = async (): Promise<void> => {
    try {
      await fetchList();
      failure.value = null;
    } catch (error) {
      failure.value = (error as Error).message;
    }
  };
  useEffect(() => void load(), []);
  const points = solvedPoints();
  const puzzles = listed.value?.puzzles ?? [];
  const solved = puzzles.filter((puzzle) => puzzle.name in points).length;
  return (
    <div class="puzzles">
      <div class="page-head">
        <h1>Puzzles</h1>
        <p class="prose">Each of these maps has one fault. Find its cause, then repair the map. Hints cost points.</p>
        {puzzles.length > 0 && (
          <p class="quiet">
            Solved in this browser: {solved} of {puzzles.length}.
          </p>
        )}
      </div>
      {failure.value && (
        <p role="alert">
          {failure.value}{" "}
          <Button icon="restart" onClick={() => void load()}>
            Try again
          </Button>
        </p>
      )}
      {Object.entries(LEVELS).map(([level, title]) => (
        <section key={level} class="puzzles-level stack" aria-label={title}>
          <h2>{title}</h2>
          <ul class="cards">
            {puzzles
              .filter((puzzle) => puzzle.level === Number(level))
              .map((puzzle) => (
                <Card key={puzzle.name} puzzle={puzzle} points={points[puzzle.name]} onOpen={onOpen} />
              ))}
          </ul>
        </section>
      ))}
      <section class="puzzles-level stack" aria-label="Your puzzles">
        <h2>Your puzzles</h2>
        {(listed.value?.mine.length ?? 0) === 0 ? (
          <p class="quiet">
            None yet. In the lab, or on the page of a log, the group <b>Share</b> makes a puzzle from what you see.
          </p>
        ) : (
          <ul class="puzzles-mine">
            {listed.value?.mine.map((own) => (
              <Mine key={own.token} made={own} onGone={() => void load()} />
            ))}
          </ul>
        )}
      </section>
    </div>
  );
}

interface CardProps {
  readonly puzzle: OfferedPuzzle;
  readonly points: number | undefined;
  readonly onOpen: (name: string) => void;
}

function Card({ puzzle, points, onOpen }: CardProps) {
  return (
    <li class="card">
      <PuzzlePicture puzzle={puzzle} />
      <h3>{puzzle.title}</h3>
      <p class="card-text">{puzzle.story}</p>
      <div class="actions">
        <Button label={`Open ${puzzle.title}`} onClick={() => onOpen(puzzle.name)}>
          Open
        </Button>
        {lecturersClass.value && <Button onClick={() => void give(puzzle.name)}>Give to the class</Button>}
        {points !== undefined && (
          <span class="puzzles-done">
            <Icon name="check" /> {points} points
          </span>
        )}
      </div>
    </li>
  );
}

function Mine({ made, onGone }: { readonly made: MadePuzzleAnswer; readonly onGone: () => void }) {
  const address = new URL(made.address, location.href).href;
  const remove = async (): Promise<void> => {
    if (!(await confirm("Remove this puzzle?", "Its link stops working, and all attempts at it end.", "Remove")))
      return;
    await toastFailure(() => removePuzzle(made.token));
    onGone();
  };
  return (
    <li>
      <strong>{made.title}</strong>
      <input
        class="field-text"
        readOnly
        aria-label={`Address of ${made.title}`}
        value={address}
        onFocus={(event) => event.currentTarget.select()}
      />
      <div class="actions">
        <Button href={made.address}>Open</Button>
        {lecturersClass.value && <Button onClick={() => void give(made.token)}>Give to the class</Button>}
        <Button kind="danger" onClick={() => void remove()}>
          Remove
        </Button>
      </div>
    </li>
  );
}
