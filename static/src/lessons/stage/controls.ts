/** What the reader can set on the stage, each with the lecture's value first. */

import type { Point, Pose } from "../../wire/protocol";
import type { SonarSettings } from "../sonar/model";
import { onPath } from "./path";

/** Poses of the scans that the reader has added by dragging the robot, and where it is now; null on the path. */
export const ownPoses = onPath<readonly Pose[]>([]);
export const ownRobot = onPath<Pose | null>(null);
/** A point of the cell that the reader has selected; null for the scene's. */
export const ownCell = onPath<Point | null>(null);

/** The inverse sensor model: the reading that was set by hand on the curve, metres; null for the stage's own. */
export const modelReading = onPath<number | null>(null);

/** The noisy wall: standard deviation of a range, and width of the window, metres. */
export const wallNoise = onPath(0.05);
export const wallWindow = onPath(0.15);

/** From a reading to a cell: the beam, the grid's origin and the side of a cell, metres. */
export const originAt = onPath<Point>([0.2, 0.2]);
export const cellSide = onPath(0.5);

/** Beams without a return: what they mean, and the largest range, metres. */
export const noReturn = onPath<"ignore" | "free" | "hit">("ignore");
export const noReturnRange = onPath(3);

/** Error of the mount's heading and error of the odometry's heading for each scan, degrees. */
export const mountError = onPath(8);
export const driftError = onPath(0.15);

/** The sonars' cone, and how the stage combines their echoes. */
export const sonarSettings = onPath<SonarSettings>({
  opening: Math.PI / 6,
  window: 0.2,
  profile: "flat",
  no_return: "ignore",
});
export const sonarMethod = onPath<"sonar_cone" | "moravec_elfes">("sonar_cone");

/** Counting: the beams of a scan, and how they update a cell. */
export const countingBeams = onPath(180);
export const countingUpdate = onPath<"per_beam" | "per_scan">("per_beam");
/** Scans of the drive after the table was removed. */
export const scansAfter = onPath(4);
/** Height of the laser's plane, metres. */
export const laserHeight = onPath(0.45);

/** What the section on the algorithm shows. */
export const algorithmView = onPath<"table" | "program" | "reading">("table");
/** Table 9.1: the number of cells that the loop has visited. */
export const visited = onPath(233);
/** The pipeline: the beam of the scan, and how far its reading has come, 0 … 6. */
export const pipelineBeam = onPath(36);
export const pipelineStep = onPath(3);

/** The map of the first section: as landmarks or as a grid. */
export const mapKind = onPath<"corners" | "grid">("corners");
export const polishedOn = onPath(true);
export const peopleOn = onPath(true);
export const peopleScans = onPath(32);
