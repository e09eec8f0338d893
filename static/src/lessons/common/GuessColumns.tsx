import type { ClassQuestion } from "../../wire/protocol";
import "./lesson.css";

interface GuessColumnsProps {
  readonly asked: ClassQuestion;
  /** The pixel of a number on the figure's axis. */
  readonly x: (value: number) => number;
  /** The pixel of the columns' foot, and the height of the longest. */
  readonly foot: number;
  readonly height: number;
}

/** The guesses of a class, as columns on the axis of a figure. */
export function GuessColumns({ asked, x, foot, height }: GuessColumnsProps) {
  const counts = asked.counts ?? [];
  const { low, high } = asked.axis ?? { low: 0, high: 1 };
  const most = Math.max(1, ...counts);
  const each = (high - low) / Math.max(1, counts.length);
  return (
    <g class="guess-columns">
      {counts.map((count, i) => {
        const [from, to] = [low + i * each, low + (i + 1) * each];
        const tall = (height * count) / most;
        return (
          <rect key={i} x={x(from) + 1} width={Math.max(1, x(to) - x(from) - 2)} y={foot - tall} height={tall}>
            <title>{`${count} guessed ${Number(from.toPrecision(4))} to ${Number(to.toPrecision(4))}`}</title>
          </rect>
        );
      })}
    </g>
  );
}
