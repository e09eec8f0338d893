/** A drive round a block and back into its first corridor: what the odometry measured of it, and two loops. */

import type { GridGeometry } from "../../grid/occupancyGrid";
import { between } from "../../grid/poses";
import { seeded } from "../../grid/random";
import { bearingOf } from "../../grid/textbook";
import type { Point, Pose } from "../../wire/protocol";
import { poseRound, rmsDistance } from "../common/drive";
import { allRound, box, chained, scanFrom, type Wall } from "../common/world";
import type { Symmetric } from "../matching/symmetric";
import type { GraphEdge } from "./solver";

export const GEOMETRY: GridGeometry = { resolution: 0.1, rows: 84, cols: 128, origin: [-1.4, -1.2, 0] };

/** Two boxes in the corners let one tell the corridors apart, if one looks. */
export const WALLS: readonly Wall[] = [
  ...box(0, 0, 10, 6),
  ...box(2, 2, 8, 4),
  ...box(8.9, 5.2, 10, 6),
  ...box(0, 5, 0.8, 6),
];

/** The corners of the middle of the corridor, driven counter-clockwise. */
const CORNERS: readonly Point[] = [
  [1, 1],
  [9, 1],
  [9, 5],
  [1, 5],
];
const SPACING = 1.5;
const BACK = 16; // the node at the place of the first one
const NODES = BACK + 2;

export const TRUTH: readonly Pose[] = Array.from({ length: NODES }, (_, k) => poseRound(CORNERS, 0.6 + SPACING * k));

const information = (metres: number, radians: number): Symmetric => [
  metres ** -2,
  0,
  0,
  metres ** -2,
  0,
  radians ** -2,
];
const DEGREE = Math.PI / 180;
const OF_ODOMETRY = information(0.06, 3 * DEGREE);
const OF_LOOP = information(0.04, 1.5 * DEGREE);

/** The odometry turns too little and slips: metres, metres, radians for each motion, besides random errors. */
const BIAS: Pose = [0.02, 0.01, -1.2 * DEGREE];

export const ODOMETRY: readonly GraphEdge[] = (() => {
  const random = seeded(3);
  return TRUTH.slice(1).map((pose, k) => {
    const [x, y, turn] = between(TRUTH[k] as Pose, pose);
    const noise = (): number => random() - 0.5;
    const relative: Pose = [
      x + BIAS[0] + 0.06 * noise(),
      y + BIAS[1] + 0.04 * noise(),
      turn + BIAS[2] + 2 * DEGREE * noise(),
    ];
    return { i: k, j: k + 1, relative, information: OF_ODOMETRY, isLoop: false };
  });
})();

/** The robot comes back to where it began: the scans of nodes 0 and 16 match. */
export const RIGHT_LOOP: GraphEdge = {
  i: 0,
  j: BACK,
  relative: between(TRUTH[0] as Pose, TRUTH[BACK] as Pose),
  information: OF_LOOP,
  isLoop: true,
};

/** The lower and the upper corridor look alike, and a matcher took them for one. */
export const WRONG_LOOP: GraphEdge = {
  i: 3,
  j: 11,
  relative: [0.1, -0.05, 0],
  information: OF_LOOP,
  isLoop: true,
};

/** The poses that the odometry alone gives. */
export const BY_ODOMETRY: readonly Pose[] = chained(
  TRUTH[0] as Pose,
  ODOMETRY.map((edge) => edge.relative),
);

const BEAMS = 72;

/** The end points of the scan of each node, in its own frame. */
export const SCANS: readonly (readonly Point[])[] = TRUTH.map((pose) => {
  const scan = scanFrom(WALLS, pose, allRound(BEAMS, 2.2));
  return Array.from(
    scan.ranges,
    (r, k): Point => [r * Math.cos(bearingOf(scan, k)), r * Math.sin(bearingOf(scan, k))],
  ).filter(([x]) => Number.isFinite(x));
});

/** How far the poses are from the true ones: the root of the mean square, metres. */
export const errorOf = (poses: readonly Pose[]): number => rmsDistance(poses, TRUTH);
