/** The scores of the poses around a loop, as the server computes them, and what a place among them stands for. */

import type { ScanPair } from "../../store/sessionSignals";
import type { ScoreLandscape } from "../../wire/http";
import type { Point } from "../../wire/protocol";

/** A cell of a hill: its score in percent, and how far it is from the loop's measurement. */
export interface HillPlace {
  readonly col: number;
  readonly row: number;
  readonly score: number;
  readonly dx: number;
  readonly dy: number;
  readonly turnDeg: number;
}

/** The cell at a column and row, which are limited to those of the hill. */
export function placeAt(hill: ScoreLandscape, col: number, row: number): HillPlace {
  const limited = (n: number): number => Math.min(hill.size - 1, Math.max(0, Math.round(n)));
  const [c, r] = [limited(col), limited(row)];
  const index = r * hill.size + c;
  const middle = (hill.size - 1) / 2;
  return {
    col: c,
    row: r,
    score: hill.scores[index] ?? 0,
    dx: (c - middle) * hill.cell_m,
    dy: (r - middle) * hill.cell_m,
    turnDeg: ((hill.turn_of[index] ?? 0) - (hill.by_turn.length - 1) / 2) * hill.turn_deg,
  };
}

/** The highest cell; of equal ones the first. */
export function summitOf(hill: ScoreLandscape): HillPlace {
  const index = hill.scores.indexOf(Math.max(...hill.scores));
  return placeAt(hill, index % hill.size, Math.floor(index / hill.size));
}

/** Where the present pose is among the cells, in columns and rows; it may lie outside. */
export function presentIn(hill: ScoreLandscape): Point {
  const middle = (hill.size - 1) / 2;
  return [
    middle + (hill.present[0] - hill.centre[0]) / hill.cell_m,
    middle + (hill.present[1] - hill.centre[1]) / hill.cell_m,
  ];
}

/** Both scans, with the later one where a cell of the hill puts it. */
export function pairAt(pair: ScanPair, hill: ScoreLandscape, { dx, dy, turnDeg }: HillPlace): ScanPair {
  const angle = (turnDeg * Math.PI) / 180;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [x0, y0] = hill.centre;
  const aligned = (pair.points.aligned ?? []).map(([x, y]): Point => {
    const [px, py] = [x - x0, y - y0];
    return [x0 + dx + c * px - s * py, y0 + dy + s * px + c * py];
  });
  return { poses: pair.poses, points: { ...pair.points, aligned } };
}
