/** The rooms in which two scans are matched, and where both were taken. */

import type { GridGeometry } from "../../grid/occupancyGrid";
import { seeded } from "../../grid/random";
import type { Pose } from "../../wire/protocol";
import { allRound, box, scanFrom, type Wall } from "../common/world";
import { type PointScan, placed, pointsOf, type SurfaceScan, scoreField, withNormals } from "./model";

/** What the figure shows, and the field of scores, which is larger: poses at its edge see beyond it. */
export const GEOMETRY: GridGeometry = { resolution: 0.1, rows: 48, cols: 64, origin: [0, 0, 0] };
export const FIELD: GridGeometry = { resolution: 0.1, rows: 88, cols: 104, origin: [-2, -2, 0] };

const BEAMS = 120;
const DEGREE = Math.PI / 180;
const NORMALS = { halfWidth: 3, reach: 0.2, most: 8, leastGap: 0.25, maxThickness: 0.03 };
const NOISE = 0.01;

/** The end points of a scan of straight walls, in the frame of the sensor. */
function pointsFrom(walls: readonly Wall[], pose: Pose, range: number, seed: number): PointScan {
  const noise = { sigma: NOISE, random: seeded(seed) };
  return pointsOf(scanFrom(walls, pose, { ...allRound(BEAMS, range), noise }));
}

/** Two scans: the fixed one in the frame of the room, the moving one in its own. */
export interface Problem {
  readonly walls: readonly Wall[];
  readonly fixedAt: Pose;
  readonly fixed: SurfaceScan;
  readonly moving: PointScan;
  readonly scores: Uint8Array;
  /** Where the moving scan was taken, and where the figure starts. */
  readonly truth: Pose;
  readonly start: Pose;
}

interface Room {
  readonly before: readonly Wall[];
  /** The walls when the second scan is taken, if others. */
  readonly after?: readonly Wall[];
  readonly range: number;
  readonly fixedAt: Pose;
  readonly truth: Pose;
  readonly start: Pose;
}

const OUTLINE: readonly Wall[] = [
  [0.5, 0.5, 5.9, 0.5],
  [5.9, 0.5, 5.9, 3.1],
  [5.9, 3.1, 4.5, 3.1],
  [4.5, 3.1, 4.5, 4.3],
  [4.5, 4.3, 0.5, 4.3],
  [0.5, 4.3, 0.5, 0.5],
];
const SHELF = box(0.5, 1.9, 0.95, 2.9);
const table = (x: number, y: number): readonly Wall[] => box(x, y, x + 1.1, y + 0.6);
const ORDINARY: Room = {
  before: [...OUTLINE, ...SHELF, ...table(2.6, 0.9)],
  range: 6,
  fixedAt: [1.9, 2.5, 20 * DEGREE],
  truth: [3.0, 2.7, -15 * DEGREE],
  start: [3.5, 2.2, 0],
};

const ROOMS = {
  room: ORDINARY,
  corridor: {
    before: [
      [-9, 1.6, 15, 1.6],
      [-9, 3.2, 15, 3.2],
    ],
    range: 2.6,
    fixedAt: [2.5, 2.4, 0],
    truth: [3.3, 2.5, 6 * DEGREE],
    start: [4.2, 2.3, 0],
  },
  symmetric: {
    before: box(0.9, 0.8, 5.5, 4.0),
    range: 6,
    fixedAt: [2.5, 2.1, 10 * DEGREE],
    truth: [4.1, 2.9, 30 * DEGREE],
    start: [2.6, 2.2, -145 * DEGREE],
  },
  table: { ...ORDINARY, after: [...OUTLINE, ...SHELF, ...table(3.1, 1.4)] },
  far: { ...ORDINARY, start: [4.9, 1.1, 60 * DEGREE] },
} satisfies Record<string, Room>;

export type RoomName = keyof typeof ROOMS;

const SIGMA = 0.1;
const FINE = 4;
/** Cells beyond which a score is 0. */
const REACH = 4;

/** A scan of the first room from a pose, in the frame of the room. */
export const scanFromPose = (pose: Pose, seed: number): PointScan =>
  placed(pointsFrom(ORDINARY.before, pose, ORDINARY.range, seed), pose);

export function problemIn(name: RoomName): Problem {
  const { before, after = before, range, fixedAt, truth, start }: Room = ROOMS[name];
  const fixed = withNormals(placed(pointsFrom(before, fixedAt, range, 1), fixedAt), NORMALS);
  const moving = pointsFrom(after, truth, range, 2);
  return { walls: before, fixedAt, fixed, moving, scores: scoreField(FIELD, fixed, SIGMA, FINE, REACH), truth, start };
}
