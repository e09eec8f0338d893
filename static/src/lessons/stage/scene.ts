/** What the stage shows at one place of the lecture. */

import type { ComponentType } from "preact";
import { cellAt } from "../../grid/lattice";
import { INITIAL_CONFIG, indexOf, type MappingConfig, type OccupancyGrid } from "../../grid/occupancyGrid";
import type { SensorModelParameters } from "../../grid/sensorModel";
import type { Point, Pose } from "../../wire/protocol";
import { cellParameters } from "../common/parameters";
import type { StageTransform } from "../common/Stage";
import type { Box, Projection } from "./camera";
import { ownCell, ownPoses } from "./controls";
import { DRIVE, FLOOR } from "./floor";
import { historyOf, type MapHistory, type Plan } from "./history";
import { type Conditions, geometryOf, USUAL } from "./sensing";

/** What is drawn over the map. */
export type Mark =
  | "lines" // borders of the cells
  | "beams" // the newest scan
  | "beam" // the cells of one beam of it
  | "reading" // the same, as far as the pipeline has come
  | "corners" // landmarks in place of cells
  | "field" // the loop of table 9.1
  | "counts" // how many beams of one scan pass each cell
  | "frame" // the grid's origin, and the way from a reading to its cell
  | "noise" // the distribution of a range at the wall
  | "odometry" // the poses that the map is made with
  | "cones" // the newest sonar readings
  | "cone" // one of them
  | "low-table"
  | "values"; // numbers in large cells

export interface Scene {
  readonly view: Box;
  readonly poses: readonly Pose[];
  readonly resolution: number;
  readonly conditions: Conditions;
  readonly config: MappingConfig;
  /** The model of a ring of sonars, which maps in place of the lidar; null for the lidar. */
  readonly cone: SensorModelParameters | null;
  /** A point of the cell whose history is drawn. */
  readonly cell: Point;
  readonly marks: readonly Mark[];
  /** Three states in place of log-odds. */
  readonly trinary: boolean;
  /** Without the map. */
  readonly bare: boolean;
  /** Another grid in place of the map. */
  readonly grid: OccupancyGrid | null;
  /** The history of the selected cell is a part of the point. It is also drawn once the reader selects a cell. */
  readonly history: boolean;
  /** Other values in place of the history of the selected cell. */
  readonly ladder: readonly number[] | null;
  /** Paints over the map, in CSS pixels of the stage; it reads the signals that it depends on. */
  readonly overlay: ((context: CanvasRenderingContext2D, at: Projection) => void) | null;
  /**
   * Drawings and handles of the scene's own, in place of the robot that makes the map, and of the selected cell with
   * its history.
   */
  readonly drawing: ComponentType<MarkProps> | null;
  /** The point that the scene makes, in one or two sentences. */
  readonly caption: (now: Shown) => string;
  /** What the reader can do with it, in a sentence; it is not printed. */
  readonly task: string;
}

/** The map that the stage shows: of a history, after some of its scans. */
export interface Shown {
  readonly history: MapHistory;
  readonly count: number;
  readonly map: OccupancyGrid;
  /** Index of the selected cell, −1 outside the map. */
  readonly index: number;
}

/** What each mark on the stage is given: where it is drawn, the scene, and how much of it is shown. */
export interface MarkProps {
  readonly transform: StageTransform;
  readonly scene: Scene;
  readonly shown: Shown;
}

/** The whole floor. */
export const WHOLE: Box = { x: FLOOR.width / 2, y: FLOOR.height / 2, width: FLOOR.width, height: FLOOR.height };

interface SceneParts {
  readonly view?: Box;
  /** Number of scans of the drive, or other poses. */
  readonly scans?: number;
  readonly poses?: readonly Pose[];
  readonly resolution?: number;
  readonly conditions?: Partial<Conditions>;
  readonly config?: Partial<MappingConfig>;
  readonly cone?: SensorModelParameters | null;
  readonly cell?: Point;
  readonly marks?: readonly Mark[];
  readonly trinary?: boolean;
  readonly bare?: boolean;
  readonly grid?: OccupancyGrid;
  readonly history?: boolean;
  readonly ladder?: readonly number[];
  readonly overlay?: Scene["overlay"];
  readonly drawing?: Scene["drawing"];
  readonly caption: string | ((now: Shown) => string);
  readonly task?: string;
}

/** A cell of the wall between the corridor and the left room: first passed and hit by turns, then certain. */
export const WALL_CELL: Point = [5.55, 3.235];

/** A scene with the lecture's parameters; the reader's own poses follow those of the drive. */
export function scene(parts: SceneParts): Scene {
  const { log_odds_hit, log_odds_miss, clamp, log_odds_min, log_odds_max } = cellParameters.value;
  const { caption } = parts;
  return {
    view: parts.view ?? WHOLE,
    poses: [...(parts.poses ?? DRIVE.slice(0, parts.scans ?? 0)), ...(parts.drawing ? [] : ownPoses.value)],
    resolution: parts.resolution ?? 0.1,
    conditions: { ...USUAL, ...parts.conditions },
    config: { ...INITIAL_CONFIG, log_odds_hit, log_odds_miss, clamp, log_odds_min, log_odds_max, ...parts.config },
    cone: parts.cone ?? null,
    cell: ownCell.value ?? parts.cell ?? WALL_CELL,
    marks: parts.marks ?? [],
    trinary: parts.trinary ?? false,
    bare: parts.bare ?? false,
    grid: parts.grid ?? null,
    history: parts.history ?? false,
    ladder: parts.ladder ?? null,
    overlay: parts.overlay ?? null,
    drawing: parts.drawing ?? null,
    caption: typeof caption === "string" ? () => caption : caption,
    task: parts.task ?? "",
  };
}

export const planOf = ({ resolution, conditions, config, cone, poses }: Scene): Plan => ({
  geometry: geometryOf(resolution, FLOOR.width, FLOOR.height),
  conditions,
  config,
  cone,
  poses,
});

export function shownOf(history: MapHistory, count: number, { cell, grid }: Scene): Shown {
  const map = grid ?? history.after(count);
  return { history, count, map, index: indexOf(map.geometry, cellAt(map.geometry, cell[0], cell[1])) };
}

/** The complete map of a scene, computed at once: for what stands beside the stage. */
export function nowOf(scene: Scene): Shown {
  const plan = planOf(scene);
  const history = historyOf(plan);
  history.advance(plan, () => false);
  return shownOf(history, plan.poses.length, scene);
}
