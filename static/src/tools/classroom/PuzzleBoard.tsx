import { useSignal } from "@preact/signals";
import { type Classroom, lecturersClass } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { toast } from "../../ui/Toast";
import type { ClassPuzzle, ClassSolver } from "../../wire/protocol";

const percent = (share: number): string => `${Math.floor(100 * share)} %`;

function described(one: ClassSolver): string {
  if (one.is_solved) return `solved, ${one.points} points`;
  return `${one.is_named ? "cause named, " : ""}repaired ${percent(one.repair)}`;
}

const sign = (one: ClassSolver): string => (one.is_solved ? "✓" : one.is_named ? "½" : "·");

/**
 * How far each follower is with the puzzle of the class, for the lecturer: numbers, no names. The numbers unfold, so that
 * the board covers one line of the page.
 */
export function PuzzleBoard({ room, puzzle }: { readonly room: Classroom; readonly puzzle: ClassPuzzle }) {
  const isOpen = useSignal(false);
  const close = async (): Promise<void> => {
    const answer = await fetch(`/api/classes/${room.code}/puzzle`, { method: "DELETE" }).catch(() => null);
    if (!answer?.ok) toast("The puzzle could not be ended: the server does not answer.", "error");
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
        {puzzle.board.map((one) => (
          <li key={one.number} class={one.is_solved ? "is-solved" : one.is_named ? "is-named" : ""}>
            <span aria-hidden="true">{sign(one)}</span> <b class="number">{one.number}</b>
            <span class="class-board-bar" aria-hidden="true">
              <i style={`width: ${100 * (one.is_solved ? 1 : one.repair)}%`} />
            </span>
            <span class="visually-hidden">{described(one)}</span>
          </li>
        ))}
      </ul>
      <p class="quiet class-board-legend">
        “·” begun, “½” cause named, “✓” solved; the bar is the repair. The numbers are those of the followers.
      </p>
    </>
  );
}
