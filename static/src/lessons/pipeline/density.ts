/** A cell as a character: three states, or six steps of probability. */

import { probability } from "../../grid/logOdds";

/** More than 0.5 of log-odds decides. */
const DECIDED = 0.5;

export const stateCharacter = (logOdds: number): string => (logOdds > DECIDED ? "#" : logOdds < -DECIDED ? "." : "?");

/** The least probability of each character; below all of them, the most certainly free. */
export const STEPS = [
  [0.9, "#"],
  [0.7, "o"],
  [0.55, "+"],
  [0.45, " "],
  [0.3, "−"],
  [0.1, "."],
] as const;

/** The character of the first step that p reaches; a dot, as for 0.1, below them all. */
export const densityCharacter = (logOdds: number): string => {
  const p = probability(logOdds);
  return STEPS.find(([least]) => p >= least)?.[1] ?? ".";
};
