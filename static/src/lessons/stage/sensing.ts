/** What the robot of the stage measures under the conditions of a scene, and the poses that its map is made with. */

import { compose } from "../../grid/lattice";
import type { GridGeometry, LaserScan, MappingConfig, OccupancyGrid } from "../../grid/occupancyGrid";
import { seeded } from "../../grid/random";
import type { SensorModelParameters } from "../../grid/sensorModel";
import { bearingOf, occupancyGridMapping } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { allRound, castRay, scanFrom, type Wall } from "../common/world";
import { type SonarScan, updateWide } from "../sonar/model";
import { SONARS, sonarScan } from "../sonar/world";
import { LOW_TABLE, POLISHED, TABLE, WALLS, walker } from "./floor";

/** What differs from an exact lidar with known poses in a world that stands still. */
export interface Conditions {
  readonly beams: number;
  /** Largest range that the lidar measures, metres. */
  readonly reach: number;
  /** Standard deviation of a range, metres. */
  readonly noise: number;
  /** The south wall is polished: a beam that meets it more than 30° off its normal does not come back. */
  readonly polished: boolean;
  readonly people: boolean;
  /** Scan from which the table is gone. */
  readonly tableUntil: number;
  /** The laser's plane cuts the low table. */
  readonly lowTable: boolean;
  /** Error of the odometry: radians of heading for each scan. */
  readonly drift: number;
  /** Error of the mount that the map is made with, radians. */
  readonly mountYaw: number;
  /** A reading that replaces a measured one: number of the scan, beam, and range in metres; null for none. */
  readonly reading: { readonly scan: number; readonly beam: number; readonly range: number } | null;
}

export const USUAL: Conditions = {
  beams: 240,
  reach: 12,
  noise: 0.01,
  polished: false,
  people: false,
  tableUntil: Number.POSITIVE_INFINITY,
  lowTable: false,
  drift: 0,
  mountYaw: 0,
  reading: null,
};

/** Angle to the normal beyond which a polished surface reflects a beam away: as in the lab. */
const SPECULAR = Math.PI / 6;
/** Largest range of the sonars of the section on them, metres. */
export const SONAR_REACH = 3.5;

export function wallsAt(index: number, conditions: Conditions): readonly Wall[] {
  return [
    ...WALLS,
    POLISHED,
    ...(index < conditions.tableUntil ? TABLE : []),
    ...(conditions.lowTable ? LOW_TABLE : []),
    ...(conditions.people ? walker(index) : []),
  ];
}

const SCANS_KEPT = 500;
/** The newest scans by their arguments: a map that is made again with another model needs the same scans. */
const scans = new Map<string, LaserScan>();

/** Scan number `index`, taken at a true pose. Equal arguments give equal scans. */
export function scanAt(pose: Pose, index: number, conditions: Conditions): LaserScan {
  const { reading } = conditions;
  if (reading) {
    const scan = scanAt(pose, index, { ...conditions, reading: null });
    if (reading.scan !== index) return scan;
    const ranges = scan.ranges.slice();
    ranges[reading.beam] = reading.range;
    return { ...scan, ranges };
  }
  const key = JSON.stringify([pose, index, conditions]);
  const scan = scans.get(key) ?? measured(pose, index, conditions);
  scans.delete(key); // so that it becomes the newest
  scans.set(key, scan);
  for (const oldest of scans.keys()) {
    if (scans.size <= SCANS_KEPT) break;
    scans.delete(oldest);
  }
  return scan;
}

function measured(pose: Pose, index: number, conditions: Conditions): LaserScan {
  const walls = wallsAt(index, conditions);
  const lidar = {
    ...allRound(conditions.beams, conditions.reach),
    noise: { sigma: conditions.noise, random: seeded(index + 1) },
  };
  const scan = scanFrom(walls, pose, lidar);
  if (!conditions.polished) return scan;
  const [ax, ay, bx, by] = POLISHED;
  const length = Math.hypot(bx - ax, by - ay);
  const [nx, ny] = [(ay - by) / length, (bx - ax) / length];
  const others = walls.filter((wall) => wall !== POLISHED);
  const ranges = scan.ranges.map((range, beam) => {
    const angle = pose[2] + scan.angle_increment * beam;
    const pane = castRay([POLISHED], pose[0], pose[1], angle);
    const meets = pane < Math.min(castRay(others, pose[0], pose[1], angle), conditions.reach);
    const cosine = Math.abs(nx * Math.cos(angle) + ny * Math.sin(angle));
    return meets && cosine < Math.cos(SPECULAR) ? Number.POSITIVE_INFINITY : range;
  });
  return { ...scan, ranges };
}

/** The pose that the map is made with: the true one, turned and shifted by the errors so far. */
export function believed(pose: Pose, index: number, conditions: Conditions, drive: readonly Pose[]): Pose {
  if (conditions.drift === 0) return pose;
  // Dead reckoning: each step of the true drive, in the frame of a heading that is off by more each time.
  let now: Pose = drive[0] ?? pose;
  const path = [...drive.slice(1, index), pose];
  let before = drive[0] ?? pose;
  path.forEach((next, i) => {
    const error = conditions.drift * (i + 1);
    const [dx, dy] = [next[0] - before[0], next[1] - before[1]];
    const [c, s] = [Math.cos(error), Math.sin(error)];
    now = [now[0] + c * dx - s * dy, now[1] + s * dx + c * dy, next[2] + error];
    before = next;
  });
  return now;
}

/** The sonar whose axis is next to a beam of the lidar. */
const sonarNextTo = (beam: number, conditions: Conditions): number =>
  Math.round((beam * SONARS) / conditions.beams) % SONARS;

/** The same of a ring of sonars; the reading that replaces another one is that of the sonar next to its beam. */
export function conesAt(pose: Pose, index: number, conditions: Conditions, model: SensorModelParameters): SonarScan {
  const scan = sonarScan(pose, model.opening, wallsAt(index, conditions), model.range_max);
  const { reading } = conditions;
  if (reading?.scan === index) scan.ranges[sonarNextTo(reading.beam, conditions)] = reading.range;
  return scan;
}

/** Range, and bearing in the sensor's frame, of a beam of a scan, with wide beams of the sonar next to it. */
export function rangeAt(
  pose: Pose,
  index: number,
  conditions: Conditions,
  cone: SensorModelParameters | null,
  beam: number,
): { readonly range: number; readonly bearing: number } {
  if (cone) {
    const [scan, k] = [conesAt(pose, index, conditions, cone), sonarNextTo(beam, conditions)];
    return { range: scan.ranges[k] ?? Number.NaN, bearing: scan.bearings[k] ?? 0 };
  }
  const scan = scanAt(pose, index, conditions);
  return { range: scan.ranges[beam] ?? Number.NaN, bearing: bearingOf(scan, beam) };
}

/** Add one scan to a map; with the model of a cone, that of a ring of sonars. */
export function addScan(
  grid: OccupancyGrid,
  truePose: Pose,
  index: number,
  conditions: Conditions,
  config: MappingConfig,
  cone: SensorModelParameters | null,
  drive: readonly Pose[],
): void {
  const pose = compose(believed(truePose, index, conditions, drive), [0, 0, conditions.mountYaw]);
  if (cone) updateWide(grid, conesAt(truePose, index, conditions, cone), pose, cone, config);
  else occupancyGridMapping(grid, scanAt(truePose, index, conditions), pose, config);
}

export const geometryOf = (resolution: number, width: number, height: number): GridGeometry => ({
  resolution,
  rows: Math.round(height / resolution),
  cols: Math.round(width / resolution),
  origin: [0, 0, 0],
});
