/** The scores of the poses around a loop, as computed by the server, and the meaning of a place among them. */

import type { ScanPair } from "../../store/sessionSignals";
import type { ScoreLandscape } from "../../wire/http";
import type { Point } from "../../wire/protocol";

/** A cell of a landscape: its score in percent, and its offset from the loop's measurement. */
export interface LandscapePlace {
  readonly col: number;
  readonly row: number;
  readonly score: number;
  readonly dx: number;
  readonly dy: number;
  readonly turnDeg: number;
}

/** The cell at a column and row, which are clamped to the landscape. */
export function placeAt(landscape: ScoreLandscape, col: number, row: number): LandscapePlace {
  const limited = (n: number): number => Math.min(landscape.size - 1, Math.max(0, Math.round(n)));
  const [c, r] = [limited(col), limited(row)];
  const index = r * landscape.size + c;
  const middle = (landscape.size - 1) / 2;
  return {
    col: c,
    row: r,
    score: landscape.scores[index] ?? 0,
    dx: (c - middle) * landscape.cell_m,
    dy: (r - middle) * landscape.cell_m,
    turnDeg: ((landscape.turn_of[index] ?? 0) - (landscape.by_turn.length - 1) / 2) * landscape.turn_deg,
  };
}

/** The highest cell; of equal ones the first. */
export function summitOf(landscape: ScoreLandscape): LandscapePlace {
  const index = landscape.scores.indexOf(Math.max(...landscape.scores));
  return placeAt(landscape, index % landscape.size, Math.floor(index / landscape.size));
}

/** The position of the current pose among the cells, in columns and rows; it may be outside. */
export function presentIn(landscape: ScoreLandscape): Point {
  const middle = (landscape.size - 1) / 2;
  return [
    middle + (landscape.present[0] - landscape.centre[0]) / landscape.cell_m,
    middle + (landscape.present[1] - landscape.centre[1]) / landscape.cell_m,
  ];
}

/** Both scans, with the later one placed by a cell of the landscape. */
export function pairAt(pair: ScanPair, landscape: ScoreLandscape, { dx, dy, turnDeg }: LandscapePlace): ScanPair {
  const angle = (turnDeg * Math.PI) / 180;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [x0, y0] = landscape.centre;
  const aligned = (pair.points.aligned ?? []).map(([x, y]): Point => {
    const [px, py] = [x - x0, y - y0];
    return [x0 + dx + c * px - s * py, y0 + dy + s * px + c * py];
  });
  return { ...pair, points: { ...pair.points, aligned } };
}
