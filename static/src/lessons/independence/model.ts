/**
 * What cell independence gives up: cells on the arc of one sonar echo, once as a grid map keeps them (a number a
 * cell) and once as the joint posterior over all maps, by Bayes' rule on every one of the 2ⁿ maps. The mapper does
 * only the first. Source: Probabilistic Robotics, section 9.4 (inverse and forward models).
 */

import { logOdds, probability } from "../../grid/logOdds";

/** What a narrow beam said of a cell. */
export type Look = "none" | "passed" | "ended";

export interface Senses {
  /** Probability of each cell before any reading. */
  readonly prior: number;
  /** How often the sonar is wrong: silent though a cell is occupied, or an echo though none is. */
  readonly sonarError: number;
  /** How often a narrow beam passes an occupied cell or ends in a free one. */
  readonly beamError: number;
}

interface Joint {
  /** Probability of each map; bit i of its index says that cell i is occupied. */
  readonly maps: readonly number[];
  readonly marginals: readonly number[];
}

const isOccupied = (map: number, cell: number): boolean => ((map >> cell) & 1) === 1;

const likelihood = (look: Look, occupied: boolean, error: number): number => {
  if (look === "none") return 1;
  return (look === "ended") === occupied ? 1 - error : error;
};

/** The joint posterior over all maps, after the echo and the looks of the narrow beam. */
export function joint(looks: readonly Look[], senses: Senses): Joint {
  const n = looks.length;
  const weights = Array.from({ length: 2 ** n }, (_, map) => {
    let weight = map === 0 ? senses.sonarError : 1 - senses.sonarError;
    looks.forEach((look, cell) => {
      const occupied = isOccupied(map, cell);
      weight *= (occupied ? senses.prior : 1 - senses.prior) * likelihood(look, occupied, senses.beamError);
    });
    return weight;
  });
  const total = weights.reduce((a, b) => a + b, 0);
  const maps = weights.map((weight) => weight / total);
  const marginals = looks.map((_, cell) => maps.reduce((sum, p, map) => sum + (isOccupied(map, cell) ? p : 0), 0));
  return { maps, marginals };
}

/** Each cell's log-odds as a grid map keeps them: what the echo alone says of it, plus the evidence of its own looks. */
export function gridMap(looks: readonly Look[], senses: Senses): readonly number[] {
  const afterEcho = joint(
    looks.map(() => "none"),
    senses,
  ).marginals;
  const evidence = logOdds(1 - senses.beamError);
  return looks.map((look, cell) => {
    const added = look === "none" ? 0 : look === "ended" ? evidence : -evidence;
    return logOdds(afterEcho[cell] ?? 0.5) + added;
  });
}

/** The probability that a grid map gives a whole map: the product over its cells. */
export function productOf(map: number, cells: readonly number[]): number {
  return cells.reduce((product, l, cell) => product * probability(isOccupied(map, cell) ? l : -l), 1);
}

interface Ranked {
  readonly map: number;
  readonly joint: number;
  readonly grid: number;
}

/** The `count` likeliest maps of the joint, "nothing there" always among them. */
export function likeliest(looks: readonly Look[], senses: Senses, count: number): readonly Ranked[] {
  const posterior = joint(looks, senses);
  const cells = gridMap(looks, senses);
  const ranked = posterior.maps
    .map((p, map) => ({ map, joint: p, grid: productOf(map, cells) }))
    .sort((a, b) => b.joint - a.joint || a.map - b.map);
  const shown = ranked.slice(0, count);
  const nothing = ranked.find((one) => one.map === 0);
  if (nothing && !shown.includes(nothing)) shown[count - 1] = nothing;
  return shown;
}
