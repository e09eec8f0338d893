/** A puzzle that is offered, an attempt at one, and what follows from its state. */

export interface Offered {
  readonly name: string;
  readonly level: number;
  readonly title: string;
  readonly story: string;
}

/** What is measured of a map: agreement and sharpness 0 … 1, entropy in bits. */
export interface Measures {
  readonly agreement: number;
  readonly sharpness: number;
  readonly entropy: number;
}

export type Measure = keyof Measures;

/** The state of an attempt: the server tells no more than the visitor has found. */
export interface Attempt {
  readonly title: string;
  readonly story: string;
  readonly level: number;
  readonly causes: readonly { readonly name: string; readonly label: string }[];
  readonly is_named: boolean;
  readonly wrong: readonly string[];
  readonly hints: readonly string[];
  readonly hints_left: number;
  readonly costs: { readonly wrong: number; readonly hint: number };
  readonly first: Measures;
  readonly goal: Measures;
  /** The measures that the repair is judged by. */
  readonly measures: readonly Measure[];
  readonly now: Measures | null;
  /** Share of the repair of the map that was checked last, and of the best one. */
  readonly repair: number | null;
  readonly best: number;
  readonly enough: number;
  readonly can_repair: boolean | null;
  /** What repairs the map, without the values, once the cause is named: names of parameters, and whether other poses. */
  readonly repaired_with: { readonly parameters: readonly string[]; readonly poses: boolean } | null;
  readonly points: number;
  readonly is_solved: boolean;
  readonly gave_up: boolean;
  readonly answer: {
    readonly cause: string;
    readonly label: string;
    readonly explanation: string;
    /** A sentence of the section. */
    readonly lesson: string;
    readonly section: string;
    readonly repair: Readonly<Record<string, number | string | boolean>>;
    readonly trajectory: string | null;
  } | null;
}

/** Whether what a check found is for the group Case: the answer, or the question for the cause of a repaired map. */
export const leadsToCase = ({ answer, best, enough, is_named }: Attempt): boolean =>
  answer !== null || (best >= enough && !is_named);

export const MEASURE_NAMES: Readonly<Record<Measure, string>> = {
  agreement: "agreement of the walls",
  sharpness: "sharpness of the walls",
  entropy: "entropy",
};

export const percent = (share: number): string => `${Math.floor(100 * share + 1e-9)} %`;

/** What a check has found, in words: how far the repair is, and what of it is missing most. Empty at the end. */
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

/** The first puzzle after the one of this name, else the first of all, that is not solved; null for none. */
export function nextPuzzle(
  puzzles: readonly Offered[],
  name: string,
  points: Readonly<Record<string, number>>,
): Offered | null {
  const at = puzzles.findIndex((one) => one.name === name);
  const inTurn = [...puzzles.slice(at + 1), ...puzzles.slice(0, at + 1)];
  return inTurn.find((one) => one.name !== name && !(one.name in points)) ?? null;
}

const counted = (n: number, one: string): string => `${n === 0 ? "no" : n} ${one}${n === 1 ? "" : "s"}`;

/** The result of an attempt in one line, to send to others; `address` is that of the page. */
export const resultText = ({ title, points, wrong, hints }: Attempt, address: string): string =>
  `“${title}”: ${points} of 100 points, ${counted(wrong.length, "wrong answer")}, ${counted(hints.length, "hint")}. ${address}`;
