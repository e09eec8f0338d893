/** The saved map of the stage's floor as costs, and the layers over it. Metres, cells of 0.1 m. */

import { bresenham } from "../../grid/bresenham";
import { LETHAL, NO_INFORMATION } from "../../grid/costs";
import { cellAt } from "../../grid/lattice";
import { indexOf } from "../../grid/occupancyGrid";
import { FREE as MOST_FREE, OCCUPIED } from "../../render/chart/LogOddsBackground";
import type { Point, Pose } from "../../wire/protocol";
import { allRound, box, scanFrom, type Wall } from "../common/world";
import { FIELD_GEOMETRY, MAPPED } from "../localization/field";
import { nowOf, scene } from "../stage/scene";
import { type Costs, FREE } from "./costmap";

export const GEOMETRY = FIELD_GEOMETRY;
const COUNT = GEOMETRY.rows * GEOMETRY.cols;
/** Nav2's first values of obstacle_max_range and raytrace_max_range. */
const MARKED = 2.5;
const CLEARED = 3;
const BEAMS = 240;

export const cellOf = ([x, y]: Point): number => indexOf(GEOMETRY, cellAt(GEOMETRY, x, y));
export const centreOfCell = (cell: number): Point => [
  ((cell % GEOMETRY.cols) + 0.5) * GEOMETRY.resolution,
  (Math.floor(cell / GEOMETRY.cols) + 0.5) * GEOMETRY.resolution,
];
export const unknown = (): Costs => new Uint8Array(COUNT).fill(NO_INFORMATION);

/** The static layer: the map of the whole drive in three states, as map_server reads it. */
export function staticLayer(): Costs {
  const { map } = nowOf(scene({ scans: 77, drawing: () => null, caption: "" }));
  return Uint8Array.from(map.logOdds, (l, i) => {
    if (map.observed[i] !== 1) return NO_INFORMATION;
    return l > OCCUPIED ? LETHAL : l < MOST_FREE ? FREE : NO_INFORMATION;
  });
}

/** A box of a width and a height about a point. */
export const boxAbout = ([x, y]: Point, width: number, height: number): readonly Wall[] =>
  box(x - width / 2, y - height / 2, x + width / 2, y + height / 2);

/** An obstacle layer after one scan: what the beams pass becomes free, then the end points lethal. */
export function observe(layer: Costs, pose: Pose, added: readonly Wall[]): Costs {
  const out = layer.slice();
  const scan = scanFrom([...MAPPED, ...added], pose, allRound(BEAMS, 12));
  const start = cellAt(GEOMETRY, pose[0], pose[1]);
  const marks: number[] = [];
  scan.ranges.forEach((range, k) => {
    if (!Number.isFinite(range)) return;
    const angle = pose[2] + scan.angle_min + k * scan.angle_increment;
    const to = (r: number): Point => [pose[0] + r * Math.cos(angle), pose[1] + r * Math.sin(angle)];
    const [x, y] = to(Math.min(range, CLEARED));
    bresenham(start, cellAt(GEOMETRY, x, y), (row, col) => {
      const i = indexOf(GEOMETRY, { row, col });
      if (i >= 0) out[i] = FREE;
      return undefined;
    });
    if (range < MARKED) marks.push(cellOf(to(range)));
  });
  for (const i of marks) if (i >= 0) out[i] = LETHAL;
  return out;
}

/** Where someone walked, a second between two places, the last one now. */
const TRAIL: readonly Point[] = Array.from({ length: 10 }, (_, k) => [1.2 + 0.42 * k, 2.6]);

/** Obstacles with a lifetime, in seconds: of the walker's trail what is younger. */
export function decayLayer(lifetime: number): Costs {
  const out = unknown();
  TRAIL.forEach(([x, y], k) => {
    const age = TRAIL.length - 1 - k;
    if (age > lifetime) return;
    for (let turn = 0; turn < 24; turn++) {
      const angle = (turn * Math.PI) / 12;
      out[cellOf([x + 0.2 * Math.cos(angle), y + 0.2 * Math.sin(angle)])] = LETHAL;
    }
  });
  return out;
}

/** A zone that was painted as forbidden. */
export function keepoutLayer(): Costs {
  const out = unknown();
  for (let i = 0; i < COUNT; i++) {
    const [x, y] = centreOfCell(i);
    if (x > 9.3 && x < 11.4 && y > 6 && y < 7.4) out[i] = LETHAL;
  }
  return out;
}

/** Distance from a point to the nearest lethal cell, metres: between the centres of the cells. */
export function distanceToLethal(costs: Costs, at: Point): number {
  const { cols, resolution } = GEOMETRY;
  const cell = cellAt(GEOMETRY, at[0], at[1]);
  let best = Number.POSITIVE_INFINITY;
  costs.forEach((cost, i) => {
    if (cost === LETHAL) best = Math.min(best, (Math.floor(i / cols) - cell.row) ** 2 + ((i % cols) - cell.col) ** 2);
  });
  return Math.sqrt(best) * resolution;
}
