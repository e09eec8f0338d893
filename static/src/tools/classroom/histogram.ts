/** The histogram of a question's answers: bars on the axis of the question. */

import type { ClassQuestion } from "../../wire/protocol";

export interface Bar {
  /** Its name: an option, or a part of the axis. */
  readonly label: string;
  readonly count: number;
  /** Share of the longest bar, 0 to 1. */
  readonly length: number;
  readonly isRight: boolean;
}

const plain = (value: number): string => String(Number(value.toPrecision(4)));

/** The letter of an option. */
export const letterOf = (option: number): string => String.fromCharCode(65 + option);

/** The bars of a question whose answers are known; none before. */
export function barsOf({ counts, options, axis, right }: ClassQuestion): readonly Bar[] {
  if (!counts) return [];
  const most = Math.max(1, ...counts);
  return counts.map((count, i) => {
    if (options) return { label: options[i] ?? "", count, length: count / most, isRight: right === i };
    const width = axis ? (axis.high - axis.low) / counts.length : 1;
    const low = (axis?.low ?? 0) + i * width;
    const isLast = i === counts.length - 1;
    return {
      label: `${plain(low)} to ${plain(low + width)}`,
      count,
      length: count / most,
      isRight: right !== null && right >= low && (right < low + width || (isLast && right <= low + width)),
    };
  });
}

/** The answers in one sentence, for screen readers. */
export function spoken(question: ClassQuestion): string {
  const bars = barsOf(question).filter((bar) => bar.count > 0);
  if (!question.counts) return `${question.answered} answered.`;
  const sentences = bars.map(({ label, count, isRight }) => `${label}: ${count}${isRight ? ", right" : ""}`).join("; ");
  return `${question.answered} answered. ${sentences}`;
}
