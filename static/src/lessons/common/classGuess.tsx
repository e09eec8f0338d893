/** The guess of a figure as a question to the whole class. */

import { useEffect, useLayoutEffect } from "preact/hooks";
import { askedAs, lecturersClass, showsAnswers } from "../../store/classroom";
import type { ClassAxis, ClassQuestion } from "../../wire/protocol";
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

/** A question whose answer is a number on an axis. */
export interface GuessQuestion {
  readonly text: string;
  readonly axis: ClassAxis;
}

interface ClassGuess {
  /** The question with its answers, while the class is asked; null otherwise. */
  readonly asked: ClassQuestion | null;
  /** Ask the class; null where this page is not the lecturer's, or the question is asked already. */
  readonly ask: (() => void) | null;
}

/**
 * The state of a question in the class. The result is revealed to the class once `right` is known to the figure, also where
 * the answers were revealed before; while
 * `isInSight`, the figure shows the answers on the lecturer's page and the class's line does not.
 */
export function useClassGuess({ text, axis }: GuessQuestion, right: number | null, isInSight: boolean): ClassGuess {
  const asked = askedAs(text);
  const room = lecturersClass.value;
  useEffect(() => {
    if (room && asked && asked.right === null && right !== null) room.send({ type: "reveal", right });
  }, [room, asked?.id, right]);
  const shows = room !== null && asked !== null && isInSight;
  useLayoutEffect(() => {
    if (shows) return showsAnswers(text);
    return;
  }, [shows, text]);
  return { asked, ask: room && !asked ? () => room.send({ type: "ask", text, axis }) : null };
}
