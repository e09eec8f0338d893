/** Text derived from the state of an attempt at a puzzle. */

import type { Attempt, OfferedPuzzle } from "../../wire/http";

export type Measure = Attempt["measures"][number];

/**
 * Whether the result of a check concerns the group Case: the answer, or the question about the cause of a repaired map.
 */
export const leadsToCase = ({ answer, best, enough, is_named }: Attempt): boolean =>
  answer !== null || (best >= enough && !is_named);

export const MEASURE_NAMES: Readonly<Record<Measure, string>> = {
  agreement: "agreement of the walls",
  sharpness: "sharpness of the walls",
  entropy: "entropy",
};

export const percent = (share: number): string => `${Math.floor(100 * share + 1e-9)} %`;

/** The result of a check as text: the progress of the repair, and its largest remaining part. Empty at the end. */
export function progressText({ answer, repair, best, enough, is_named, measures, first, goal, now }: Attempt): string {
  if (answer !== null) return "";
  if (repair === null || now === null) return "Not checked yet.";
  if (best >= enough && !is_named) return `Repaired ${percent(repair)}. What was the cause?`;
  const shares = measures.map((name) => [name, (now[name] - first[name]) / (goal[name] - first[name] || 1)] as const);
  const [least] = shares.sort(([, a], [, b]) => a - b);
  const done = repair < 0.005 ? "Repaired 0 %: no better than at first" : `Repaired ${percent(repair)}`;
  const missing = least && shares.length > 1 ? ` Farthest from its goal: ${MEASURE_NAMES[least[0]]}.` : "";
  const better = best > repair + 0.005 ? ` The best so far was ${percent(best)}.` : "";
  return `${done}; it is solved at ${percent(enough)}.${missing}${better}`;
}

/** The first unsolved puzzle after the one of this name, else the first of all; null for none. */
export function nextPuzzle(
  puzzles: readonly OfferedPuzzle[],
  name: string,
  points: Readonly<Record<string, number>>,
): OfferedPuzzle | null {
  const at = puzzles.findIndex((puzzle) => puzzle.name === name);
  const inTurn = [...puzzles.slice(at + 1), ...puzzles.slice(0, at + 1)];
  return inTurn.find((puzzle) => puzzle.name !== name && !(puzzle.name in points)) ?? null;
}

const counted = (n: number, noun: string): string => `${n === 0 ? "no" : n} ${noun}${n === 1 ? "" : "s"}`;

/** The result of an attempt in one line, to send to others; `address` is that of the page. */
export const resultText = ({ title, points, wrong, hints }: Attempt, address: string): string =>
  `“${title}”: ${points} of 100 points, ${counted(wrong.length, "wrong answer")}, ${counted(hints.length, "hint")}. ${address}`;
