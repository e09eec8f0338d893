/**
 * What is lost with the assumption of independent cells: cells on the arc of one sonar echo, as a grid map stores them
 * (one number for each cell), and as the joint posterior by Bayes' rule over all 2ⁿ maps. The mapper does only the
 * first. Source: Probabilistic Robotics, chapter 9 (inverse and forward models).
 */

import { logOdds, probability } from "../../grid/cellValues";

/** What a narrow beam measured in a cell. */
export type BeamResult = "none" | "passed" | "ended";

export interface SensorParameters {
  /** Probability of each cell before any reading. */
  readonly prior: number;
  /** How often the sonar is wrong: no echo though a cell is occupied, or an echo though none is. */
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

const likelihood = (result: BeamResult, occupied: boolean, error: number): number => {
  if (result === "none") return 1;
  return (result === "ended") === occupied ? 1 - error : error;
};

/** The joint posterior over all maps, after the echo and the beamResults of the narrow beam. */
export function joint(beamResults: readonly BeamResult[], sensor: SensorParameters): Joint {
  const n = beamResults.length;
  const weights = Array.from({ length: 2 ** n }, (_, map) => {
    let weight = map === 0 ? sensor.sonarError : 1 - sensor.sonarError;
    beamResults.forEach((result, cell) => {
      const occupied = isOccupied(map, cell);
      weight *= (occupied ? sensor.prior : 1 - sensor.prior) * likelihood(result, occupied, sensor.beamError);
    });
    return weight;
  });
  const total = weights.reduce((a, b) => a + b, 0);
  const maps = weights.map((weight) => weight / total);
  const marginals = beamResults.map((_, cell) =>
    maps.reduce((sum, p, map) => sum + (isOccupied(map, cell) ? p : 0), 0),
  );
  return { maps, marginals };
}

/** Each cell's log-odds as a grid map stores them: after the echo alone, plus the evidence of the beam in the cell. */
export function gridMap(beamResults: readonly BeamResult[], sensor: SensorParameters): readonly number[] {
  const afterEcho = joint(
    beamResults.map(() => "none"),
    sensor,
  ).marginals;
  const evidence = logOdds(1 - sensor.beamError);
  return beamResults.map((result, cell) => {
    const added = result === "none" ? 0 : result === "ended" ? evidence : -evidence;
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
export function likeliest(
  beamResults: readonly BeamResult[],
  sensor: SensorParameters,
  count: number,
): readonly Ranked[] {
  const posterior = joint(beamResults, sensor);
  const cells = gridMap(beamResults, sensor);
  const ranked = posterior.maps
    .map((p, map) => ({ map, joint: p, grid: productOf(map, cells) }))
    .sort((a, b) => b.joint - a.joint || a.map - b.map);
  const shown = ranked.slice(0, count);
  const nothing = ranked.find((column) => column.map === 0);
  if (nothing && !shown.includes(nothing)) shown[count - 1] = nothing;
  return shown;
}
