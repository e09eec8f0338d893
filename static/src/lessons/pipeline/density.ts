/** A map as characters: three states, or six steps of probability. */

import { probability } from "../../grid/logOdds";
import type { OccupancyGrid } from "../../grid/occupancyGrid";

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

/** The whole map as lines, the greatest y first. */
export function asText({ geometry, logOdds }: OccupancyGrid, character: (logOdds: number) => string): string {
  const lines: string[] = [];
  for (let row = geometry.rows - 1; row >= 0; row--) {
    let line = "";
    for (let col = 0; col < geometry.cols; col++) line += character(logOdds[row * geometry.cols + col] ?? 0);
    lines.push(line);
  }
  return lines.join("\n");
}
