// Written by `python -m server.stream.generate` from the Structs of server/stream and server/parts: change those.

import {
  type Check,
  isFlag,
  isInteger,
  isListOf,
  isLiteral,
  isNull,
  isNumber,
  isObject,
  isPositive,
  isRecordOf,
  isText,
  isTuple,
  oneOf,
  optional,
} from "./checks";

/** Version of the protocol, as the WebSocket's subprotocol. */
export const SUBPROTOCOL = "gridbloom.v3";

/** value of a parameter */
export type Value = number | string | boolean;

/** One row of a parameter table. */
export interface Parameter {
  /** key in the values */
  readonly name: string;
  /** short name on the page */
  readonly label: string;
  /** panel that shows it */
  readonly group: string;
  /** which of the other fields apply */
  readonly kind: "choice" | "flag" | "number";
  /** initial value */
  readonly initial: Value;
  /** explanation, one sentence */
  readonly sentence: string;
  /** unit of a number; may be empty */
  readonly unit: string;
  /** least value of a number */
  readonly low: number;
  /** greatest value of a number */
  readonly high: number;
  /** step of a number's slider */
  readonly step: number;
  /** values of a choice */
  readonly choices: readonly string[];
  /** sensor models to which it applies; empty: all */
  readonly only_for: readonly string[];
}

/** parameters by name */
export type Values = Readonly<Record<string, Value>>;

/** A parameter table and its current values. */
export interface Table {
  /** one row for each parameter */
  readonly table: readonly Parameter[];
  /** present values */
  readonly values: Values;
}

/** A trajectory of a log. */
export interface TrajectoryInfo {
  /** name, as the command `trajectory` takes it */
  readonly name: string;
  /** source of the poses */
  readonly description: string;
  /** whether they were found from the scans, as by SLAM */
  readonly from_scans: boolean;
  /** trajectory before it with the same path; null for none */
  readonly same_as: string | null;
}

/** The log of a log session. */
export interface LogInfo {
  /** id in the library */
  readonly id: string;
  /** sensor of the map; " + " between several */
  readonly topic: string;
  /** how the scans are cut out of point clouds or depth images; null for those of a lidar */
  readonly cut: Table | null;
  /** trajectory of the map */
  readonly trajectory: string;
  /** all trajectories of the log */
  readonly trajectories: readonly TrajectoryInfo[];
  /** reference and estimate whose errors are told first; null for one trajectory */
  readonly compared: readonly [string, string] | null;
  /** beams of each scan */
  readonly n_beams: number;
  /** scans of the log */
  readonly n_scans: number;
  /** recorded time from the earliest stamp to the latest, s; 0 for a log without times */
  readonly duration_s: number;
  /** file format of the log */
  readonly format: string;
  /** remarks of the reader, one sentence each */
  readonly notes: readonly string[];
  /** earliest stamp, s since 1970; null for a clock that began elsewhere */
  readonly start_s: number | null;
}

/** kind of content of a layer */
export type LayerKind = "graph" | "grid" | "path" | "points";

/** One of the layers of a session. */
export interface LayerInfo {
  /** `layer` of its binary frames, from 1 */
  readonly id: number;
  /** name, as the commands take it */
  readonly name: string;
  /** kind of its content */
  readonly kind: LayerKind;
  /** title on the page */
  readonly title: string;
  /** how the page paints it: a palette of grids, or an overlay */
  readonly style: string;
  /** names of the columns of its table: `x`, `y` and more; empty for a grid */
  readonly columns: readonly string[];
}

/** [x, y, yaw] in m, m, rad */
export type Pose = readonly [x: number, y: number, yaw: number];

/** [x, y] in m */
export type Point = readonly [x: number, y: number];

/** The parameters of the second map of a session that differ from those of the first. */
export interface Compared {
  /** parameters in which it differs */
  readonly values: Values;
  /** whether the robot's faults affect it */
  readonly with_faults: boolean;
  /** log sessions: trajectory of the second map */
  readonly trajectory?: string;
  /** log sessions: id of its log; null for the session's own log */
  readonly log?: string | null;
  /** log sessions: topic of its scans */
  readonly topic?: string | null;
  /** log sessions: title of its log */
  readonly title?: string;
}

/** wall from corner to corner, or axis-aligned box between two corners; cm in the map frame */
export type DrawnSolid = readonly [kind: "box" | "wall", x0: number, y0: number, x1: number, y1: number];

/** Edits of a world. */
export interface Edits {
  /** solids that were drawn */
  readonly added: readonly DrawnSolid[];
  /** indices of the built solids that were erased */
  readonly erased: readonly number[];
}

/** [ax, ay, bx, by] in m */
export type Segment = readonly [ax: number, ay: number, bx: number, by: number];

/** A solid of a world with heights of its own, such as a low table or a lintel. */
export interface Block {
  /** its corners seen from above */
  readonly outline: readonly Point[];
  /** height of its bottom, m */
  readonly low: number;
  /** height of the highest point of its top, m */
  readonly high: number;
}

/** state of a cell by its probability */
export type CellState = "free" | "occupied" | "unknown";

/** The contribution of one beam to a cell. */
export interface Contribution {
  /** number of the contribution, from 1 */
  readonly n: number;
  /** index of the scan, from 0 */
  readonly scan: number;
  /** recorded time of the scan, s */
  readonly stamp: number;
  /** index of the beam, from 0 */
  readonly beam: number;
  /** T_map_laser with the mount correction of the parameters */
  readonly pose: Pose;
  /** angle of the beam from the sensor's x axis, rad */
  readonly bearing: number;
  /** reading, m; null for no return */
  readonly range: number | null;
  /** whether it raised the log-odds */
  readonly hit: boolean;
  /** log-odds added */
  readonly increment: number;
  /** log-odds of the cell afterwards, clamped */
  readonly log_odds: number;
  /** its topic, where several sensors make the map */
  readonly sensor?: string;
  /** true for a miss that counts for nothing, as its scan hits the cell */
  readonly outweighed?: boolean;
}

/** cells by state in B */
export type StateCounts = readonly [number, number, number];

/** one number for each of two maps: [A, B] */
export type Sides = readonly [a: number, b: number];

/** Comparison of two maps on one lattice, A being the second map and B the first; see `mapper.grid.compare`. */
export interface Numbers {
  /** cells compared */
  readonly cells: number;
  /** states[i][j]: cells with state i in A and j in B; order free, occupied, unknown */
  readonly states: readonly [StateCounts, StateCounts, StateCounts];
  /** cells with the same state in A and B */
  readonly same: number;
  /** cells observed only in A, only in B */
  readonly only: Sides;
  /** cells observed in both */
  readonly both: number;
  /** entropy of each map, bits */
  readonly entropy_bits: Sides;
  /** contrast of each map */
  readonly contrast: Sides;
  /** mean absolute difference of the probabilities */
  readonly mean_difference: number;
  /** greatest absolute difference of the probabilities */
  readonly max_difference: number;
  /** centre of that cell; null if the maps do not differ */
  readonly max_at: Point | null;
}

/** [x, y, z] in m */
export type Place = readonly [x: number, y: number, z: number];

/** The values at the ends of a colour scale. Values beyond them have the colours of the ends. */
export interface ColourScale {
  /** at the beginning */
  readonly low: number;
  /** at the end */
  readonly high: number;
  /** `m`; `s` after the first scan; `scan`: its number; empty: as the file states it */
  readonly unit: string;
}

/** Differences between the map of a session in 3D, B, and another one, A. */
export interface VolumeChanges {
  /** of A */
  readonly title: string;
  /** voxels that are free in A and occupied in B */
  readonly appeared: number;
  /** voxels that are occupied in A and free in B */
  readonly vanished: number;
  /** voxels with one state in both */
  readonly same: number;
  /** voxels that only A knows */
  readonly only_first: number;
  /** voxels that only B knows */
  readonly only_second: number;
}

/** Update of a voxel of a surface by one scan. */
export interface SurfaceUpdate {
  /** number of the scan, from 1 */
  readonly scan: number;
  /** signed distance that it measured, m, cut at the truncation */
  readonly measured: number;
  /** weight of the measurement */
  readonly added: number;
  /** mean distance before, m; null: unknown */
  readonly before: number | null;
  /** mean distance after, m */
  readonly after: number;
  /** weight of the mean after */
  readonly weight: number;
}

/** Update of a voxel by one scan. */
export interface VoxelUpdate {
  /** number of the scan, from 1 */
  readonly scan: number;
  /** whether a beam ended in it; else beams passed it */
  readonly hit: boolean;
  /** how many, at most 64 */
  readonly beams: number;
  /** log-odds before; null: unknown */
  readonly before: number | null;
  /** log-odds after */
  readonly after: number;
}

/** The measured point in a voxel that is nearest to the line of sight, or to the queried place. */
export interface VoxelPoint {
  /** where it is, m */
  readonly place: Place;
  /** number of its scan, from 1 */
  readonly scan: number;
  /** what is known of it: intensity, class, rgb */
  readonly values: Readonly<Record<string, readonly number[]>>;
  /** points in the voxel */
  readonly count: number;
}

/** Numbers of patches of each class before the last change of parameters. */
export interface TerrainCounts {
  /** names of the parameters */
  readonly changed: readonly string[];
  /** patches that were safe */
  readonly safe: number;
  /** patches that were unsafe */
  readonly unsafe: number;
  /** patches with too few points */
  readonly unknown: number;
}

/** A queried patch of terrain, or the window around it to which its plane is fitted. */
export interface TerrainPatch {
  /** the place that was asked about, m */
  readonly x: number;
  /** the place that was asked about, m */
  readonly y: number;
  /** its centre, m */
  readonly centre: Point;
  /** half of its side, m */
  readonly half: number;
  /** the height above which its heights are, m */
  readonly base: number;
  /** P, 4 × 4 row by row: the sum of v vᵀ with v = [1 x y z]ᵀ about its centre */
  readonly moments: readonly number[];
  /** its ground points, with those that RANSAC leaves out */
  readonly n: number;
  /** x, y, z of these points about its centre, m; of many every second one, or fewer */
  readonly points: readonly number[];
  /** x, y, z in the middle of each edge, z on the plane of the neighbour there, of those with one */
  readonly edges: readonly number[];
  /** P of its four children in the quadtree, about its centre; empty: it has none */
  readonly children: readonly (readonly number[])[];
  /** why it has its class, one sentence */
  readonly why: string;
  /** safe, unsafe or unknown */
  readonly state: string;
}

/** A stroke of the brush that paints keepout zones and speed limits. */
export interface BrushStroke {
  /** width of the brush, m */
  readonly width: number;
  /** whether it erases */
  readonly erases: boolean;
  /** places of the brush's middle, at least one */
  readonly points: readonly Point[];
  /** value of the speed filter's mask, 1 to 100; null: a keepout zone */
  readonly speed?: number | null;
}

/** Contribution of one layer of a costmap to a cell. */
export interface LayerCost {
  /** name of the layer */
  readonly layer: string;
  /** its own cost there, 255: none */
  readonly cost: number;
  /** cost of the costmap after it */
  readonly master: number;
  /** why, one sentence */
  readonly sentence: string;
}

/** The axis for guessing a number. */
export interface ClassAxis {
  /** least guess */
  readonly low: number;
  /** greatest guess */
  readonly high: number;
  /** unit, may be empty */
  readonly unit?: string;
}

/** A question for the class, and the answers to it. */
export interface ClassQuestion {
  /** number of the question, from 1 */
  readonly id: number;
  /** the question */
  readonly text: string;
  /** the answers to choose from; null: a number is guessed */
  readonly options: readonly string[] | null;
  /** the axis of the guess; null: an option is chosen */
  readonly axis: ClassAxis | null;
  /** whether the result is shown to all */
  readonly is_revealed: boolean;
  /** whether no more answers are taken; always so once it is revealed */
  readonly is_closed: boolean;
  /** how many answers are counted */
  readonly answered: number;
  /** answers for each option, or in each part of the axis; followers: null before the reveal */
  readonly counts: readonly number[] | null;
  /** the right option from 0, or number; null: there is none, or not yet */
  readonly right: number | null;
  /** answers of followers up to this number are counted; null: of all */
  readonly last_number?: number | null;
}

/** Progress of one follower with the puzzle; followers are known by number only. */
export interface ClassSolver {
  /** number of the follower */
  readonly number: number;
  /** whether the cause is named */
  readonly is_named: boolean;
  /** share of the repair, 0 to 1 */
  readonly repair: number;
  /** whether the puzzle is solved */
  readonly is_solved: boolean;
  /** points, 0 to 100 */
  readonly points: number;
}

/** The puzzle that the class solves. */
export interface ClassPuzzle {
  /** its title */
  readonly title: string;
  /** how many have begun */
  readonly begun: number;
  /** how many have solved it */
  readonly solved: number;
  /** how far each is; lecturer only, for others empty */
  readonly board: readonly ClassSolver[];
}

/** The current slide without its notes, the only part of the lecturer's deck that followers receive. */
export interface ClassSlide {
  /**
   * the title with a map, a section of the lecture, its derivation, a text of the lecturer's, or a page in the slide
   */
  readonly kind: "derivation" | "lab" | "log" | "section" | "text" | "title";
  /** name of the section; null for other kinds */
  readonly section?: string | null;
  /** title; null for a section */
  readonly title?: string | null;
  /** the paragraphs of a text that are shown so far; of a section, its answer once it is shown */
  readonly text?: string | null;
  /** address of a shared view in the slide; null for pages that only the lecturer may open */
  readonly address?: string | null;
}

/** The part of the map shown in a picture, with the size of the picture. */
export interface ClassLook {
  /** the place in the middle, m */
  readonly x: number;
  /** the place in the middle, m */
  readonly y: number;
  /** metres that a pixel shows */
  readonly scale: number;
  /** width of the picture, pixels */
  readonly width: number;
  /** height of the picture, pixels */
  readonly height: number;
}

/** State of the lecturer's page. Places are map metres. */
export interface ClassView {
  /** the page; logs: the map of a log; other: no page that can be followed */
  readonly page: "lab" | "lecture" | "logs" | "other";
  /** fragment of its address: section, or slide and step */
  readonly hash?: string;
  /** the slide that is shown; null: none */
  readonly slide?: ClassSlide | null;
  /** whether the screen is blank */
  readonly blank?: boolean;
  /** the visible part of the map; null: all of it */
  readonly look?: ClassLook | null;
  /** where the pointer is in the map */
  readonly pointer?: Point | null;
  /** the selected cell */
  readonly pinned?: Point | null;
  /** the cell whose updates are explained */
  readonly explained?: Point | null;
  /** number of the selected update; null: the newest */
  readonly update?: number | null;
  /** the open group of controls */
  readonly group?: string | null;
  /** where the pointer is on the slide, as fractions of its width and height */
  readonly on_slide?: readonly [number, number] | null;
}

/** First message of a connection: description of the session. */
export interface Hello {
  readonly type: "hello";
  /** name of the protocol, `gridbloom.v3` */
  readonly protocol: string;
  /** id of the session */
  readonly session: string;
  /** `simulation`: a simulated robot; `log`: a recording; `costmaps`, `map`; `volume`: a map in 3D */
  readonly kind: string;
  /** title of the world or log */
  readonly title: string;
  /** changes when the server restarts or the session is created again */
  readonly epoch_id: string;
  /** least and greatest playback speed */
  readonly speeds: readonly [least: number, greatest: number];
  /** mapping parameters */
  readonly parameters: Table;
  /** parameters of the simulated sensor; null if there is none */
  readonly sensor: Table | null;
  /** the log; null if there is none */
  readonly log: LogInfo | null;
  /** parameters of the parts of the session, by the type of the command that sets them */
  readonly tables: Readonly<Record<string, readonly Parameter[]>>;
  /** simulations: name of the world */
  readonly world?: string;
  /** simulations: seed; the same seed and commands give the same scans */
  readonly seed?: number;
}

/** The layers of the session. Sent at the start and after a change. */
export interface LayersMessage {
  readonly type: "layers";
  /** the layers; without a subscription the first is sent */
  readonly layers: readonly LayerInfo[];
}

/**
 * The grid to which the tiles of an epoch belong. Tiles of another epoch are ignored. Sent before the first tiles of
 * an epoch, for each grid that the page has subscribed to.
 */
export interface Geometry {
  readonly type: "geometry";
  /** id of the layer */
  readonly layer: number;
  /** number of the epoch; grows with each new geometry */
  readonly epoch: number;
  /** side of a cell, m */
  readonly resolution: number;
  /** cells along y */
  readonly rows: number;
  /** cells along x */
  readonly cols: number;
  /** pose of the outer corner of cell (0, 0) in the map frame */
  readonly origin: Pose;
  /** value of -127 in a tile */
  readonly low: number;
  /** value of +127 in a tile */
  readonly high: number;
  /** cells along the side of a tile */
  readonly tile: 64;
}

/**
 * Newest state of the session, sent directly before the tiles of the same instant. The fields of the scan
 * (`scan_pose`, `believed_scan_pose`, `ranges`, `angle_min`, `angle_increment`, `bearings`, `beam_width`,
 * `range_max`) are sent only with a new scan. If `ranges` is missing, all of them are unchanged.
 */
export interface FrameMessage {
  readonly type: "frame";
  /** T_map_laser at the newest scan, without the mount correction */
  readonly scan_pose?: Pose;
  /** estimate of `scan_pose` that the map uses; only while the odometry drifts */
  readonly believed_scan_pose?: Pose;
  /** readings of the newest scan, m; null for no return or no valid reading */
  readonly ranges?: readonly (number | null)[];
  /** bearing of the first beam, rad */
  readonly angle_min?: number;
  /** angle between two beams, rad */
  readonly angle_increment?: number;
  /** bearing of each beam if they are uneven (sonars), rad */
  readonly bearings?: readonly number[];
  /** full angle of a sonar's cone, rad */
  readonly beam_width?: number;
  /** largest range that is used, m */
  readonly range_max?: number;
  /** monotonic clock of the server, s; for measuring the age of the frame */
  readonly t: number;
  /** whether the session plays */
  readonly playing: boolean;
  /** playback speed; 1 is real time */
  readonly speed: number;
  /** scans in the map */
  readonly index: number;
  /** scans in total */
  readonly count: number;
  /** simulated or recorded time of the state, s */
  readonly stamp: number;
  /** T_map_base now */
  readonly pose: Pose;
  /** T_map_laser now, without the mount correction of the parameters */
  readonly sensor_pose: Pose;
  /** whether the robot explores by itself */
  readonly auto: boolean;
  /** estimate of `pose` that the map uses; only while the odometry drifts */
  readonly believed_pose?: Pose;
  /** time in which the map was last recomputed with other parameters, ms */
  readonly remade_ms?: number;
}

/** Log sessions: the robot's path. Sent at the start and after a change of the trajectory. */
export interface Trajectory {
  readonly type: "trajectory";
  /** name of the trajectory */
  readonly name: string;
  /** frame of the poses and of the map; null where the log names none */
  readonly frame: string | null;
  /** a point for each `every`-th scan */
  readonly every: number;
  /** position of the base at those scans */
  readonly poses: readonly Point[];
  /** recorded time at those scans, from the first scan, s */
  readonly stamps: readonly number[];
}

/** Log sessions: the trajectories of the log, after one was added, replaced or deleted. */
export interface Trajectories {
  readonly type: "trajectories";
  /** all trajectories of the log */
  readonly trajectories: readonly TrajectoryInfo[];
  /** reference and estimate whose errors are told first; null for one trajectory */
  readonly compared: readonly [string, string] | null;
}

/** Current parameters, sent after each change and after a refused change. */
export interface ParametersMessage {
  readonly type: "parameters";
  /** mapping parameters */
  readonly values: Values;
  /** simulated sensor; null if there is none */
  readonly sensor: Values | null;
  /** simulations: faults that affect the map */
  readonly faults?: Values;
  /** the second map; null if there is none */
  readonly compare?: Compared | null;
}

/** Simulations: the true walls and boxes. Sent at the start and after a change. */
export interface WorldMessage {
  readonly type: "world";
  /** name of the world */
  readonly name: string;
  /** title of the world */
  readonly title: string;
  /** all worlds, as the command `world` takes them */
  readonly names: readonly string[];
  /** [x0, y0, x1, y1], m */
  readonly bounds: readonly [x0: number, y0: number, x1: number, y1: number];
  /** outlines of the solids */
  readonly polygons: readonly (readonly Point[])[];
  /** of each polygon: index of the built solid, or -1 - its index in `added` */
  readonly ids: readonly number[];
  /** edits of the world */
  readonly edits: Edits;
  /** faces that give no return while the fault `specular` is on */
  readonly polished: readonly Segment[];
  /** solids with heights of their own */
  readonly blocks?: readonly Block[];
}

/** Simulations: how two maps, with and without clamping, forget what an `edit` with `watch` erased. */
export interface Forgetting {
  readonly type: "forgetting";
  /** occupied cells of what was erased; 0: nothing is watched */
  readonly cells: number;
  /** scans since then */
  readonly scans: number;
  /** scans after which 9 in 10 of the cells were free with clamping; null: not yet */
  readonly with_clamp: number | null;
  /** the same without clamping */
  readonly without_clamp: number | null;
  /** share of the cells that are free with clamping, 0 to 1 */
  readonly free_with_clamp: number;
  /** the same without clamping */
  readonly free_without_clamp: number;
}

/** Progress of a computation that takes more than 0.3 s. Sent four times a second until it has ended. */
export interface WorkingMessage {
  readonly type: "working";
  /** time since its start, s; null: it has ended */
  readonly elapsed_s: number | null;
  /** share that is done, 0 to 1; null if not known */
  readonly fraction: number | null;
  /** `map`, or what a part computes, such as `costmap`; its words are in the page */
  readonly what?: string;
}

/** A notice to the user, such as the end of the log. */
export interface NoticeMessage {
  readonly type: "notice";
  /** stable name of the notice */
  readonly code: string;
  /** one sentence */
  readonly message: string;
}

/** The last command was refused, or the session had an error. The connection stays open. */
export interface ErrorMessage {
  readonly type: "error";
  /** stable name of the error */
  readonly code: string;
  /** one sentence */
  readonly message: string;
  /** reserved */
  readonly detail?: null;
}

/** Answer to `inspect`: one cell. */
export interface CellMessage {
  readonly type: "cell";
  /** row of the cell */
  readonly row: number;
  /** column of the cell */
  readonly col: number;
  /** epoch of the geometry */
  readonly epoch: number;
  /** x of the cell's centre in the map frame, m */
  readonly x: number;
  /** y of the cell's centre in the map frame, m */
  readonly y: number;
  /** whether any beam has updated the cell */
  readonly observed: boolean;
  /** log-odds of being occupied */
  readonly log_odds: number;
  /** probability of being occupied */
  readonly p_occ: number;
  /** state by the thresholds of the map */
  readonly state: CellState;
  /** name of the layer of that map */
  readonly layer: string;
}

/** Answer to `why`: the beams that updated a cell in the map of `index` scans. */
export interface WhyMessage {
  readonly type: "why";
  /** row of the cell */
  readonly row: number;
  /** column of the cell */
  readonly col: number;
  /** epoch of the geometry */
  readonly epoch: number;
  /** scans in the map */
  readonly index: number;
  /** log-odds of the cell */
  readonly log_odds: number;
  /** log-odds of a cell before any scan */
  readonly prior: number;
  /** lower clamping limit; null without clamping */
  readonly log_odds_min: number | null;
  /** upper clamping limit; null without clamping */
  readonly log_odds_max: number | null;
  /** whether each scan counts once */
  readonly per_scan: boolean;
  /** beams that updated the cell */
  readonly total: number;
  /** those that raised its log-odds */
  readonly hits: number;
  /** those that count for nothing, as their scans hit the cell */
  readonly outweighed: number;
  /** index of the first scan that updated it */
  readonly first_scan: number | null;
  /** [n, log-odds] over all contributions, at most 600 points; extremes are kept */
  readonly curve: readonly (readonly [number, number])[];
  /** at most 300 contributions, up to the requested one */
  readonly contributions: readonly Contribution[];
  /** name of the layer of that map */
  readonly layer: string;
}

/** Logs: the object that was clicked in a 3D view of the session. Sent to the page of that view. */
export interface PickedMessage {
  readonly type: "picked";
  /** a loop of the pose graph, a pose of the path, which the map then goes to, or a cell of the map */
  readonly what: "cell" | "loop" | "pose";
  /** x of its place in the map frame, m */
  readonly x: number;
  /** y of its place in the map frame, m */
  readonly y: number;
  /** yaw of the pose, rad; null for others */
  readonly yaw: number | null;
  /** scans up to that of the pose, itself included; null for others */
  readonly index: number | null;
  /** number of the loop's edge; null for others */
  readonly edge: number | null;
}

/** Answer to a click in a 3D view of a page that measures: the object at that place. */
export interface PlaceMessage {
  readonly type: "place";
  /** x of the place in the map frame, m */
  readonly x: number;
  /** y of the place in the map frame, m */
  readonly y: number;
  /** height, m; null: a place of a plane map */
  readonly z: number | null;
  /** side of the voxel there, m; 0: a measured point; null: a place of a plane map */
  readonly size: number | null;
}

/** Settings of the 3D view of the session, from when it is first opened. */
export interface SceneMessage {
  readonly type: "scene";
  /** places of the camera */
  readonly cameras: readonly ("above" | "east" | "north" | "overview" | "south" | "west" | "first person" | "follow")[];
  /** whether each layer is shown, by its label */
  readonly layers: Readonly<Record<string, boolean>>;
  /** height of the map's columns, of the default */
  readonly height: number;
  /** distance between two lines of the layer `Grid`, m */
  readonly grid: number;
}

/** Answer to `ping`. */
export interface Pong {
  readonly type: "pong";
  /** id of the ping */
  readonly id: number;
  /** monotonic clock of the server, s */
  readonly t: number;
}

/** Log sessions: comparison of the map, B, with the second map, A. Both fields are null without a comparison. */
export interface ComparisonMessage {
  readonly type: "comparison";
  /** scans in the map */
  readonly index: number;
  /** reason why the maps cannot be compared, one sentence */
  readonly refused: string | null;
  /** the comparison */
  readonly numbers: Numbers | null;
}

/** Estimate of the particle filter; in a simulation, with its error. */
export interface LocalizationMessage {
  readonly type: "localization";
  /** whether the robot is localized */
  readonly is_on: boolean;
  /** of a simulation: plan, moved or other, as the command localize has it */
  readonly map: string;
  /** localization parameters that differ from the first ones */
  readonly values: Values;
  /** the best estimate */
  readonly pose: Pose | null;
  /** the pose, in a simulation the true one, that it is an estimate of */
  readonly at: Pose | null;
  /** variances of the estimate: xx, xy, yy in m², yaw in rad² */
  readonly covariance: readonly [number, number, number, number] | null;
  /** whether the particles agree on one place */
  readonly is_converged: boolean;
  /** whether other places in the map were ruled out, too */
  readonly is_sure: boolean;
  /** weight of the heaviest cluster, 0 to 1 */
  readonly share: number;
  /** how well the last scan that was used fits, 0 to 1 */
  readonly fit: number;
  /** of the histogram of particles in bins of 0.5 m and 10°, bits */
  readonly entropy: number;
  /** number of particles */
  readonly n_particles: number;
  /** scans that were used */
  readonly n_updates: number;
  /** distance of the estimate from the true pose, m */
  readonly error_m: number | null;
  /** its error in heading, rad */
  readonly error_rad: number | null;
}

/** The 3D map of a simulation. Cells that are only in this map are in the layer `only_in_3d`. */
export interface Map3dMessage {
  readonly type: "map3d";
  /** whether there is one */
  readonly is_on: boolean;
  /** parameters of the 3D sensor and the map */
  readonly values: Values;
  /** scans in the map */
  readonly scans: number;
  /** scans that are recorded; more than `scans` while the map is made again */
  readonly taken: number;
  /** cells of its projection that are occupied, and are not in the 2D map */
  readonly only_in_3d: number;
  /** why it does not grow any more; null: it does */
  readonly problem: string | null;
  /** free and occupied voxels */
  readonly known: number;
  /** nodes of its octree, whose equal leaves are joined */
  readonly nodes: number;
  /** those without children */
  readonly leaves: number;
  /** the octree: log-odds and children of each node */
  readonly octree_bytes: number;
  /** the map as it is kept: blocks of 8 × 8 × 8 voxels, and their hash */
  readonly block_bytes: number;
  /** a dense grid of the world, 4 bytes for each voxel */
  readonly dense_bytes: number;
}

/** Sessions in 3D: the contents of the map and its display options. Sent at the start and after changes. */
export interface VolumeMessage {
  readonly type: "volume";
  /** what is shown, and how */
  readonly look: Table;
  /** least coordinates of the map, m */
  readonly low: Place;
  /** greatest coordinates of the map, m */
  readonly high: Place;
  /** whether it is made of scans; else it is an octree */
  readonly has_scans: boolean;
  /** whether it is known where the sensor was, so that space is free */
  readonly has_free: boolean;
  /** the axis of the file that is z here */
  readonly up: string;
  /** points of the scans in the map; leaves of an octree */
  readonly points: number;
  /** points that were left out: beyond the lattice */
  readonly left_out: number;
  /** voxels */
  readonly occupied: number;
  /** voxels */
  readonly free: number;
  /** memory of the map in blocks of 8³ voxels */
  readonly bytes: number;
  /** memory of a dense grid of the same box, 4 bytes a voxel */
  readonly dense_bytes: number;
  /** nodes of the pruned octree; null while the map changes */
  readonly nodes: number | null;
  /** chunks of 32³ voxels that are drawn */
  readonly chunks: number;
  /** rectangles that are drawn */
  readonly quads: number;
  /** chunks that are still to be drawn again */
  readonly pending: number;
  /** what the points can be coloured by */
  readonly colours: readonly string[];
  /** of the colours by intensity, time or difference; null: not known, others */
  readonly scale: ColourScale | null;
  /** the comparison with another map; null: there is none */
  readonly compared: VolumeChanges | null;
}

/**
 * Sessions in 3D: the surface from truncated signed distances. Sent at the start and after changes. A simulation
 * sends it while its surface is shown; its parameters are those of the 3D map.
 */
export interface SurfaceMessage {
  readonly type: "surface";
  /** its parameters; empty where no surface can be made */
  readonly table: readonly Parameter[];
  /** their present values */
  readonly values: Values;
  /** truncation that is used, m */
  readonly truncation: number;
  /** scans in the surface */
  readonly index: number;
  /** blocks of 8³ voxels */
  readonly blocks: number;
  /** memory of the blocks */
  readonly bytes: number;
  /** triangles that are drawn */
  readonly triangles: number;
  /** chunks of 32³ voxels that have triangles */
  readonly chunks: number;
  /** chunks that are still to be meshed again */
  readonly pending: number;
  /** scans after which the surface is kept, to go back to */
  readonly snapshots: readonly number[];
  /** why it is not drawn; null: it is */
  readonly problem: string | null;
}

/** Answer to `voxel` and to a click in 3D while the surface is shown, for all clients. Null: none is chosen. */
export interface SurfaceVoxelMessage {
  readonly type: "surface_voxel";
  /** its centre, m */
  readonly centre: Place | null;
  /** its side, m */
  readonly size: number;
  /** mean signed distance, m, positive before; null: unknown */
  readonly distance: number | null;
  /** weight of the mean */
  readonly weight: number;
  /** scans in the surface */
  readonly index: number;
  /** scans that measured it */
  readonly total: number;
  /** at most the last 200, oldest first */
  readonly updates: readonly SurfaceUpdate[];
}

/** Answer to `voxel` and to a click in 3D, for all clients: why a voxel has its state. Null: none is chosen. */
export interface VoxelMessage {
  readonly type: "voxel";
  /** its centre, m */
  readonly centre: Place | null;
  /** its side, m */
  readonly size: number;
  /** log-odds of being occupied; null: unknown */
  readonly log_odds: number | null;
  /** state by the map's threshold */
  readonly state: CellState;
  /** scans in the map */
  readonly index: number;
  /** scans that updated it */
  readonly total: number;
  /** those of which a beam ended in it */
  readonly hits: number;
  /** at most the last 200, oldest first */
  readonly updates: readonly VoxelUpdate[];
  /** a point in it; null: it has none */
  readonly point?: VoxelPoint | null;
}

/** The terrain of a simulation or a cloud, in the layers `terrain_costs` and `terrain_values`. */
export interface TerrainMessage {
  readonly type: "terrain";
  /** whether it is assessed */
  readonly is_on: boolean;
  /** its parameters */
  readonly values: Values;
  /** points that it is made of */
  readonly points: number;
  /** those that the filter takes for ground */
  readonly ground: number;
  /** points of which the filter is not sure */
  readonly unsure: number;
  /** ground points that RANSAC leaves out of the planes */
  readonly left_out: number;
  /** Cohen's kappa of ground and objects, %; null: the truth is not known */
  readonly kappa: number | null;
  /** points that are classified wrongly, %; null: as above */
  readonly total_error: number | null;
  /** what they are compared with; null: as above */
  readonly truth: string | null;
  /** patches that are safe */
  readonly safe: number;
  /** patches that are unsafe */
  readonly unsafe: number;
  /** patches with too few points */
  readonly unknown: number;
  /** side of a patch, m */
  readonly size: number;
  /** the classes before the newest change of parameters; null: there was none */
  readonly before: TerrainCounts | null;
  /** the patch that was asked about; null: none was */
  readonly patch: TerrainPatch | null;
  /** why it cannot be assessed, one sentence; null: it is */
  readonly problem: string | null;
}

/** The costmap over the map of a simulation or a log. */
export interface CostmapMessage {
  readonly type: "costmap";
  /** whether there is one */
  readonly is_on: boolean;
  /** navigation parameters */
  readonly values: Values;
  /** corners of the robot's outline, in its frame, without padding */
  readonly footprint: readonly Point[];
  /** of the padded outline, m */
  readonly inscribed_radius: number;
  /** of the padded outline, m */
  readonly circumscribed_radius: number;
  /** all that is painted */
  readonly keepout: readonly BrushStroke[];
}

/** Answer to `cost`: what each layer says of a cell, bottom first. */
export interface CostMessage {
  readonly type: "cost";
  /** the place that was asked for, m */
  readonly x: number;
  /** the place that was asked for, m */
  readonly y: number;
  /** one for each layer that is on */
  readonly layers: readonly LayerCost[];
  /** the speed limit there, a sentence; null: none is painted */
  readonly speed: string | null;
}

/** Answer to `nav2`. */
export interface Nav2Message {
  readonly type: "nav2";
  /** a Nav2 parameter file; null: the parameters were set */
  readonly text: string | null;
}

/** Sessions with a costmap: the path to the goal; its points are in the layer `plan`. */
export interface PathMessage {
  readonly type: "path";
  /** the goal; null: there is none */
  readonly goal: Point | null;
  /** whether the robot drives along it */
  readonly drives: boolean;
  /** length, m; null: there is no path */
  readonly length: number | null;
  /** sum of the costs of its steps; null: there is no path */
  readonly cost: number | null;
  /** time along it at the desired velocity, less where speed limits are, s; null: there is no path */
  readonly travel_s: number | null;
  /** whether it ends at the goal */
  readonly reaches_goal: boolean;
  /** why there is no path, or why it ends before the goal */
  readonly reason: string | null;
  /** the point ahead that the robot aims at */
  readonly carrot: Point | null;
  /** duration of the planning, ms */
  readonly plan_ms: number;
  /** the painted speed limit at the robot, in words; null: none */
  readonly speed_limit: string | null;
}

/** Maps: the edits so far. */
export interface MapEditsMessage {
  readonly type: "map_edits";
  /** number of edits that are not undone */
  readonly n: number;
  /** number of edits that are undone */
  readonly undone: number;
  /** the last of the edits, oldest first, a phrase each */
  readonly last: readonly string[];
  /** cells of keepout zones */
  readonly keepout_cells: number;
  /** cells with a speed limit */
  readonly speed_cells: number;
  /** what the reader of the map noted */
  readonly notes: readonly string[];
}

/** Log sessions: a note on the log was written, changed or deleted. Pages then request the notes again. */
export interface NotesMessage {
  readonly type: "notes";
  /** when, seconds since 1970 */
  readonly changed_s: number;
}

/** Acknowledge that the binary frames up to `seq` were painted. */
export interface AckCommand {
  readonly type: "ack";
  /** number of the newest such frame */
  readonly seq: number;
}

/** After a reconnect, before `subscribe`: the tiles of a grid that the page still has. Only newer ones are sent. */
export interface ResumeCommand {
  readonly type: "resume";
  /** of the `hello` of the earlier connection */
  readonly epoch_id: string;
  /** name of the grid */
  readonly layer: string;
  /** epoch of the tiles */
  readonly epoch: number;
  /** all tiles up to this revision were received */
  readonly revision: number;
}

/** Set the layers to send from now on. Without it the first layer is sent. */
export interface SubscribeCommand {
  readonly type: "subscribe";
  /** names of all layers that are wanted */
  readonly layers: readonly string[];
}

/** Mark a place on the map in the 3D views of this page. */
export interface SelectCommand {
  readonly type: "select";
  /** the place; null for none */
  readonly place?: Point | null;
}

/** Draw this page's measurement in its 3D views, where each click is then answered with `place`. */
export interface MeasureCommand {
  readonly type: "measure";
  /** the points so far, map metres; null: nothing is measured */
  readonly points?: readonly Place[] | null;
  /** whether the last is joined to the first: a polygon */
  readonly closed?: boolean;
}

/** Start playing. */
export interface PlayCommand {
  readonly type: "play";
}

/** Pause. */
export interface PauseCommand {
  readonly type: "pause";
}

/** Restart with an empty map. */
export interface RestartCommand {
  readonly type: "restart";
}

/** Pause, and step forward or back by some scans. */
export interface StepCommand {
  readonly type: "step";
  /** number of scans; negative: back */
  readonly scans?: number;
}

/** Set the playback speed. */
export interface SpeedCommand {
  readonly type: "speed";
  /** within `speeds` of `hello`; 1 is real time */
  readonly value: number;
}

/** Log sessions: seek the map after a number of scans. */
export interface SeekCommand {
  readonly type: "seek";
  /** number of scans in the map, 0 to that of the log */
  readonly index: number;
}

/** Log sessions: cancel the current computation. A seek stops where it is; parameters are restored. */
export interface CancelCommand {
  readonly type: "cancel";
}

/** Change mapping parameters and recompute the map. */
export interface ParametersCommand {
  readonly type: "parameters";
  /** new values; the others stay */
  readonly values: Values;
}

/** Simulations: change the simulated sensor. */
export interface SensorCommand {
  readonly type: "sensor";
  /** new values; the others stay */
  readonly values: Values;
}

/** Simulations: set which faults of the robot affect the map. The whole map is recomputed. */
export interface FaultsCommand {
  readonly type: "faults";
  /** `drift`, `specular`: true or false */
  readonly values: Values;
}

/** Simulations: make a second map of the same recording. For logs use `PUT /api/sessions/{id}/compare`. */
export interface CompareCommand {
  readonly type: "compare";
  /** parameters in which it differs; null: no second map */
  readonly values?: Values | null;
}

/** Simulations: place the robot; a position inside a wall is replaced by the nearest free one. */
export interface TeleportCommand {
  readonly type: "teleport";
  /** x in the map frame, m */
  readonly x: number;
  /** y in the map frame, m */
  readonly y: number;
  /** heading, rad; null: unchanged */
  readonly yaw?: number | null;
}

/** Simulations: drive by hand. The speed is held for 0.5 s. */
export interface DriveCommand {
  readonly type: "drive";
  /** forward speed, m/s */
  readonly linear: number;
  /** turn rate, rad/s, positive to the left */
  readonly angular: number;
}

/** Simulations: switch the robot's own exploration on or off. */
export interface AutoCommand {
  readonly type: "auto";
  /** whether it explores */
  readonly value?: boolean;
}

/** Simulations: set all edits of the world; they replace the earlier ones. */
export interface EditCommand {
  readonly type: "edit";
  /** walls and boxes to draw */
  readonly added?: readonly DrawnSolid[];
  /** indices of the built solids to erase */
  readonly erased?: readonly number[];
  /** send `forgetting` about what this erases */
  readonly watch?: boolean;
}

/** Simulations: restart in another world. */
export interface WorldCommand {
  readonly type: "world";
  /** one of `names` of the message `world` */
  readonly name: string;
  /** walls and boxes to draw */
  readonly added?: readonly DrawnSolid[];
  /** indices of the built solids to erase */
  readonly erased?: readonly number[];
}

/** Log sessions: recompute the map with another trajectory. */
export interface TrajectoryCommand {
  readonly type: "trajectory";
  /** one of the `trajectories` of `hello` */
  readonly name: string;
}

/** Request a `pong`. */
export interface PingCommand {
  readonly type: "ping";
  /** returned in the answer */
  readonly id: number;
}

/** Request the state of one cell; answered with `cell`. */
export interface InspectCommand {
  readonly type: "inspect";
  /** row of the cell */
  readonly row: number;
  /** column of the cell */
  readonly col: number;
  /** epoch of that map's geometry */
  readonly epoch: number;
  /** name of the layer of that map */
  readonly layer?: string;
}

/** Request the contributions to a cell; answered with `why`. Of several in a tick only the last is answered. */
export interface WhyCommand {
  readonly type: "why";
  /** row of the cell */
  readonly row: number;
  /** column of the cell */
  readonly col: number;
  /** epoch of that map's geometry */
  readonly epoch: number;
  /** last contribution to describe, from 1; null: the newest */
  readonly until?: number | null;
  /** name of the layer of that map */
  readonly layer?: string;
}

/** Simulations: begin to localize the robot in a map, from an unknown pose, change the parameters, or end it. */
export interface LocalizeCommand {
  readonly type: "localize";
  /** whether it is localized */
  readonly value?: boolean;
  /** localization parameters that differ from the first ones */
  readonly values?: Values;
  /** plan: of the world; moved: with its furniture elsewhere; other: of another world */
  readonly map?: string;
  /** keep the particles of the filter that runs on this map, if there is one */
  readonly keep?: boolean;
}

/** Simulations: begin a 3D map from the robot's 3D sensor, change it, or end it. */
export interface Map3dCommand {
  readonly type: "map3d";
  /** whether there is one */
  readonly value?: boolean;
  /** parameters of the sensor and the map to change; the others stay */
  readonly values?: Values;
}

/** Sessions in 3D: change the display options. */
export interface VolumeLookCommand {
  readonly type: "volume_look";
  /** new values; the others stay */
  readonly values: Values;
}

/** Sessions in 3D: change parameters of the surface, which is then recomputed. */
export interface SurfaceCommand {
  readonly type: "surface";
  /** new values; the others stay */
  readonly values: Values;
}

/** Sessions in 3D: ask why the voxel at a place has its state; answered with `voxel`. Null: choose none. */
export interface VoxelCommand {
  readonly type: "voxel";
  /** x in the map frame, m */
  readonly x?: number | null;
  /** y in the map frame, m */
  readonly y?: number | null;
  /** z in the map frame, m */
  readonly z?: number | null;
}

/** Sessions in 3D: ask for the first voxel that a line of sight meets; answered with `voxel`. */
export interface VoxelRayCommand {
  readonly type: "voxel_ray";
  /** where it begins, m */
  readonly origin: readonly [number, number, number];
  /** where it goes */
  readonly direction: readonly [number, number, number];
}

/** Sessions in 3D: keep the current map to compare later ones with it, or end the comparison. */
export interface VolumeKeepCommand {
  readonly type: "volume_keep";
  /** whether to compare */
  readonly value?: boolean;
}

/** Simulations with a 3D map, and clouds: begin to assess their terrain, change it, query a patch, or end. */
export interface TerrainCommand {
  readonly type: "terrain";
  /** whether it is assessed */
  readonly value?: boolean;
  /** parameters to change; the others stay */
  readonly values?: Values;
  /** x of a place in the patch that is asked about, m; null: none */
  readonly x?: number | null;
  /** y of that place, m */
  readonly y?: number | null;
}

/** Simulations and logs: begin a costmap over the robot's map, change it, or end it. Omitted fields are kept. */
export interface CostmapCommand {
  readonly type: "costmap";
  /** false: end it */
  readonly value?: boolean;
  /** navigation parameters to change */
  readonly values?: Values;
  /** corners of the robot's outline, in its frame */
  readonly footprint?: readonly Point[] | null;
  /** all that is painted; replaces the earlier */
  readonly keepout?: readonly BrushStroke[] | null;
}

/** Sessions with a costmap: ask why a cell has its cost; answered with `cost`. */
export interface CostCommand {
  readonly type: "cost";
  /** x in the map frame, m */
  readonly x: number;
  /** y in the map frame, m */
  readonly y: number;
}

/** Sessions with a costmap: ask for its parameters as a Nav2 parameter file, or set them from one. */
export interface Nav2Command {
  readonly type: "nav2";
  /** a Nav2 parameter file; null: answer with one */
  readonly text?: string | null;
}

/** Sessions with a costmap: set the goal of the path, and whether the robot drives along it. */
export interface GoalCommand {
  readonly type: "goal";
  /** x in the map frame, m; null: no goal */
  readonly x?: number | null;
  /** y in the map frame, m */
  readonly y?: number | null;
  /** whether it drives; null: as before */
  readonly drives?: boolean | null;
}

/** Maps: edit the map; see `mapper.editing`. Points are in the coordinates after the earlier edits. */
export interface MapEditCommand {
  readonly type: "map_edit";
  /** paint, fill, keepout, speed, despeckle, rotate, crop or origin */
  readonly op: string;
  /** paint: the line; fill, keepout, speed: the corners; crop: two corners; origin: the place */
  readonly points?: readonly Point[] | null;
  /** paint and fill: free, occupied or unknown */
  readonly state?: string | null;
  /** paint: width of the brush, m */
  readonly width?: number | null;
  /** keepout and speed: value of the filter's mask, 1 to 100, 0 for none; despeckle: most cells */
  readonly value?: number | null;
  /** rotate: by this; origin: its heading, rad */
  readonly angle?: number | null;
}

/** Maps: undo edits, or redo them. */
export interface MapHistoryCommand {
  readonly type: "map_history";
  /** negative: number of steps to undo; positive: to redo */
  readonly steps: number;
}

/** The state of the class, sent to all its members, at most five times a second. */
export interface ClassState {
  readonly type: "class";
  /** the code of the class */
  readonly code: string;
  /** followers that are connected */
  readonly present: number;
  /** whether no one else can join */
  readonly is_locked: boolean;
  /** whether the class is over */
  readonly has_ended: boolean;
  /** numbers of the followers who ask for the robot; lecturer only */
  readonly hands: readonly number[];
  /** number of the follower who drives the robot; null: the lecturer */
  readonly driver: number | null;
  /** the question that is asked; null: none */
  readonly question: ClassQuestion | null;
  /** the puzzle that is solved; null: none */
  readonly puzzle?: ClassPuzzle | null;
  /** whether no page of the lecturer's is connected */
  readonly is_lecturer_away?: boolean;
  /** whether answers are counted only of who had joined when the question was asked */
  readonly counts_joined_only?: boolean;
}

/** The first message: the role of the receiver in the class. */
export interface ClassWelcome {
  readonly type: "welcome";
  /** what one may do */
  readonly role: "follower" | "lecturer";
  /** number of a follower, from 1; 0: the lecturer */
  readonly number: number;
  /** what one has answered to the question; null: nothing */
  readonly answer: number | null;
}

/** Current state of the lecturer's page, sent to the followers. */
export interface ClassViewMessage {
  readonly type: "view";
  /** what the lecturer shows */
  readonly view: ClassView;
  /** number of the session that is shown, from 1; 0: none */
  readonly stage: number;
}

/** The explanation of the selected cell, as shown on the lecturer's page, sent to the followers. */
export interface ClassExplained {
  readonly type: "explained";
  /** the explanation; null: none is shown */
  readonly why: WhyMessage | null;
}

/** A command was refused. */
export interface ClassError {
  readonly type: "refused";
  /** stable name of the error */
  readonly code: string;
  /** one sentence */
  readonly message: string;
  /** of an answer to the question that is asked: the one that is counted */
  readonly answer?: number | null;
}

/** Lecturer: the current state of the page. */
export interface ShowCommand {
  readonly type: "show";
  /** what it shows */
  readonly view: ClassView;
  /** id of the session that it shows; null: none */
  readonly session?: string | null;
}

/** Lecturer: the explanation shown on the page. */
export interface ExplainCommand {
  readonly type: "explain";
  /** the explanation; null: none is shown */
  readonly why?: WhyMessage | null;
}

/** Lecturer: ask the class a question, with options to choose from or an axis for guessing a number. */
export interface AskCommand {
  readonly type: "ask";
  /** the question */
  readonly text: string;
  /** two to eight answers; null: a number is guessed */
  readonly options?: readonly string[] | null;
  /** the axis of the guess */
  readonly axis?: ClassAxis | null;
  /** the right option from 0, or number; null: there is none */
  readonly right?: number | null;
}

/** Lecturer: show the result to all. No more answers are accepted. */
export interface RevealCommand {
  readonly type: "reveal";
  /** the right answer, if it was not known before */
  readonly right?: number | null;
}

/** Lecturer: accept no more answers to the question, or accept them again. Its result is not shown yet. */
export interface StopCommand {
  readonly type: "stop";
  /** false: answers are taken again, and those given are kept */
  readonly value?: boolean;
}

/** Lecturer: remove the question. Its result is kept until the class ends. */
export interface CloseCommand {
  readonly type: "close";
}

/** Lecturer: close the class to new listeners, or open it again. */
export interface LockCommand {
  readonly type: "lock";
  /** whether it is locked */
  readonly value: boolean;
}

/** Lecturer: choose whose answers are counted, for all questions of the class. */
export interface CountCommand {
  readonly type: "count";
  /** only of who had joined when the question was asked */
  readonly joined_only: boolean;
}

/** Lecturer: hand the robot to a follower, or take it back. */
export interface HandCommand {
  readonly type: "hand";
  /** number of the follower; null: take it back */
  readonly number?: number | null;
}

/** Follower: answer the question; a later answer replaces it. */
export interface AnswerCommand {
  readonly type: "answer";
  /** id of the question */
  readonly question: number;
  /** the option from 0, or the number */
  readonly value: number;
}

/** Follower: request the robot, or withdraw the request. */
export interface RaiseCommand {
  readonly type: "raise";
  /** whether one asks for it */
  readonly value: boolean;
}

export type ServerMessage =
  | Hello
  | LayersMessage
  | Geometry
  | FrameMessage
  | Trajectory
  | Trajectories
  | ParametersMessage
  | WorldMessage
  | Forgetting
  | WorkingMessage
  | NoticeMessage
  | ErrorMessage
  | CellMessage
  | WhyMessage
  | PickedMessage
  | PlaceMessage
  | SceneMessage
  | Pong
  | ComparisonMessage
  | LocalizationMessage
  | Map3dMessage
  | VolumeMessage
  | SurfaceMessage
  | SurfaceVoxelMessage
  | VoxelMessage
  | TerrainMessage
  | CostmapMessage
  | CostMessage
  | Nav2Message
  | PathMessage
  | MapEditsMessage
  | NotesMessage;

export type Command =
  | AckCommand
  | ResumeCommand
  | SubscribeCommand
  | SelectCommand
  | MeasureCommand
  | PlayCommand
  | PauseCommand
  | RestartCommand
  | StepCommand
  | SpeedCommand
  | SeekCommand
  | CancelCommand
  | ParametersCommand
  | SensorCommand
  | FaultsCommand
  | CompareCommand
  | TeleportCommand
  | DriveCommand
  | AutoCommand
  | EditCommand
  | WorldCommand
  | TrajectoryCommand
  | PingCommand
  | InspectCommand
  | WhyCommand
  | LocalizeCommand
  | Map3dCommand
  | VolumeLookCommand
  | SurfaceCommand
  | VoxelCommand
  | VoxelRayCommand
  | VolumeKeepCommand
  | TerrainCommand
  | CostmapCommand
  | CostCommand
  | Nav2Command
  | GoalCommand
  | MapEditCommand
  | MapHistoryCommand;

export type ClassMessage =
  | ClassState
  | ClassWelcome
  | ClassViewMessage
  | ClassExplained
  | ClassError;

export type ClassCommand =
  | ShowCommand
  | ExplainCommand
  | AskCommand
  | RevealCommand
  | StopCommand
  | CloseCommand
  | LockCommand
  | CountCommand
  | HandCommand
  | AnswerCommand
  | RaiseCommand;

const isValue: Check = oneOf(isNumber, isText, isFlag);
const isParameter: Check = isObject({
  name: isText,
  label: isText,
  group: isText,
  kind: isLiteral("choice", "flag", "number"),
  initial: isValue,
  sentence: isText,
  unit: isText,
  low: isNumber,
  high: isNumber,
  step: isNumber,
  choices: isListOf(isText),
  only_for: isListOf(isText),
});
const isValues: Check = isRecordOf(isValue);
const isTable: Check = isObject({
  table: isListOf(isParameter),
  values: isValues,
});
const isTrajectoryInfo: Check = isObject({
  name: isText,
  description: isText,
  from_scans: isFlag,
  same_as: oneOf(isText, isNull),
});
const isLogInfo: Check = isObject({
  id: isText,
  topic: isText,
  cut: oneOf(isTable, isNull),
  trajectory: isText,
  trajectories: isListOf(isTrajectoryInfo),
  compared: oneOf(isTuple(isText, isText), isNull),
  n_beams: isInteger,
  n_scans: isInteger,
  duration_s: isNumber,
  format: isText,
  notes: isListOf(isText),
  start_s: oneOf(isNumber, isNull),
});
const isLayerKind: Check = isLiteral("graph", "grid", "path", "points");
const isLayerInfo: Check = isObject({
  id: isInteger,
  name: isText,
  kind: isLayerKind,
  title: isText,
  style: isText,
  columns: isListOf(isText),
});
const isPose: Check = isTuple(isNumber, isNumber, isNumber);
const isPoint: Check = isTuple(isNumber, isNumber);
const isCompared: Check = isObject({
  values: isValues,
  with_faults: isFlag,
  trajectory: optional(isText),
  log: optional(oneOf(isText, isNull)),
  topic: optional(oneOf(isText, isNull)),
  title: optional(isText),
});
const isDrawnSolid: Check = isTuple(isLiteral("box", "wall"), isInteger, isInteger, isInteger, isInteger);
const isEdits: Check = isObject({
  added: isListOf(isDrawnSolid),
  erased: isListOf(isInteger),
});
const isSegment: Check = isTuple(isNumber, isNumber, isNumber, isNumber);
const isBlock: Check = isObject({
  outline: isListOf(isPoint),
  low: isNumber,
  high: isNumber,
});
const isCellState: Check = isLiteral("free", "occupied", "unknown");
const isContribution: Check = isObject({
  n: isInteger,
  scan: isInteger,
  stamp: isNumber,
  beam: isInteger,
  pose: isPose,
  bearing: isNumber,
  range: oneOf(isNumber, isNull),
  hit: isFlag,
  increment: isNumber,
  log_odds: isNumber,
  sensor: optional(isText),
  outweighed: optional(isFlag),
});
const isStateCounts: Check = isTuple(isInteger, isInteger, isInteger);
const isSides: Check = isTuple(isNumber, isNumber);
const isNumbers: Check = isObject({
  cells: isInteger,
  states: isTuple(isStateCounts, isStateCounts, isStateCounts),
  same: isInteger,
  only: isSides,
  both: isInteger,
  entropy_bits: isSides,
  contrast: isSides,
  mean_difference: isNumber,
  max_difference: isNumber,
  max_at: oneOf(isPoint, isNull),
});
const isPlace: Check = isTuple(isNumber, isNumber, isNumber);
const isColourScale: Check = isObject({
  low: isNumber,
  high: isNumber,
  unit: isText,
});
const isVolumeChanges: Check = isObject({
  title: isText,
  appeared: isInteger,
  vanished: isInteger,
  same: isInteger,
  only_first: isInteger,
  only_second: isInteger,
});
const isSurfaceUpdate: Check = isObject({
  scan: isInteger,
  measured: isNumber,
  added: isNumber,
  before: oneOf(isNumber, isNull),
  after: isNumber,
  weight: isNumber,
});
const isVoxelUpdate: Check = isObject({
  scan: isInteger,
  hit: isFlag,
  beams: isInteger,
  before: oneOf(isNumber, isNull),
  after: isNumber,
});
const isVoxelPoint: Check = isObject({
  place: isPlace,
  scan: isInteger,
  values: isRecordOf(isListOf(isNumber)),
  count: isInteger,
});
const isTerrainCounts: Check = isObject({
  changed: isListOf(isText),
  safe: isInteger,
  unsafe: isInteger,
  unknown: isInteger,
});
const isTerrainPatch: Check = isObject({
  x: isNumber,
  y: isNumber,
  centre: isPoint,
  half: isNumber,
  base: isNumber,
  moments: isListOf(isNumber),
  n: isInteger,
  points: isListOf(isNumber),
  edges: isListOf(isNumber),
  children: isListOf(isListOf(isNumber)),
  why: isText,
  state: isText,
});
const isBrushStroke: Check = isObject({
  width: isPositive,
  erases: isFlag,
  points: isListOf(isPoint),
  speed: optional(oneOf(isInteger, isNull)),
});
const isLayerCost: Check = isObject({
  layer: isText,
  cost: isInteger,
  master: isInteger,
  sentence: isText,
});
const isClassAxis: Check = isObject({
  low: isNumber,
  high: isNumber,
  unit: optional(isText),
});
const isClassQuestion: Check = isObject({
  id: isInteger,
  text: isText,
  options: oneOf(isListOf(isText), isNull),
  axis: oneOf(isClassAxis, isNull),
  is_revealed: isFlag,
  is_closed: isFlag,
  answered: isInteger,
  counts: oneOf(isListOf(isInteger), isNull),
  right: oneOf(isNumber, isNull),
  last_number: optional(oneOf(isInteger, isNull)),
});
const isClassSolver: Check = isObject({
  number: isInteger,
  is_named: isFlag,
  repair: isNumber,
  is_solved: isFlag,
  points: isInteger,
});
const isClassPuzzle: Check = isObject({
  title: isText,
  begun: isInteger,
  solved: isInteger,
  board: isListOf(isClassSolver),
});
const isClassSlide: Check = isObject({
  kind: isLiteral("derivation", "lab", "log", "section", "text", "title"),
  section: optional(oneOf(isText, isNull)),
  title: optional(oneOf(isText, isNull)),
  text: optional(oneOf(isText, isNull)),
  address: optional(oneOf(isText, isNull)),
});
const isClassLook: Check = isObject({
  x: isNumber,
  y: isNumber,
  scale: isPositive,
  width: isPositive,
  height: isPositive,
});
const isClassView: Check = isObject({
  page: isLiteral("lab", "lecture", "logs", "other"),
  hash: optional(isText),
  slide: optional(oneOf(isClassSlide, isNull)),
  blank: optional(isFlag),
  look: optional(oneOf(isClassLook, isNull)),
  pointer: optional(oneOf(isPoint, isNull)),
  pinned: optional(oneOf(isPoint, isNull)),
  explained: optional(oneOf(isPoint, isNull)),
  update: optional(oneOf(isInteger, isNull)),
  group: optional(oneOf(isText, isNull)),
  on_slide: optional(oneOf(isTuple(isNumber, isNumber), isNull)),
});
const isWhyMessage: Check = isObject({
  row: isInteger,
  col: isInteger,
  epoch: isInteger,
  index: isInteger,
  log_odds: isNumber,
  prior: isNumber,
  log_odds_min: oneOf(isNumber, isNull),
  log_odds_max: oneOf(isNumber, isNull),
  per_scan: isFlag,
  total: isInteger,
  hits: isInteger,
  outweighed: isInteger,
  first_scan: oneOf(isInteger, isNull),
  curve: isListOf(isTuple(isInteger, isNumber)),
  contributions: isListOf(isContribution),
  layer: isText,
});

/** The check of each field of each message from the server; a message may have more fields. */
export const FIELDS: Readonly<Record<ServerMessage["type"], Readonly<Record<string, Check>>>> = {
  hello: {
    protocol: isText,
    session: isText,
    kind: isText,
    title: isText,
    epoch_id: isText,
    speeds: isTuple(isNumber, isNumber),
    parameters: isTable,
    sensor: oneOf(isTable, isNull),
    log: oneOf(isLogInfo, isNull),
    tables: isRecordOf(isListOf(isParameter)),
    world: optional(isText),
    seed: optional(isInteger),
  },
  layers: {
    layers: isListOf(isLayerInfo),
  },
  geometry: {
    layer: isInteger,
    epoch: isInteger,
    resolution: isPositive,
    rows: isInteger,
    cols: isInteger,
    origin: isPose,
    low: isNumber,
    high: isNumber,
    tile: isLiteral(64),
  },
  frame: {
    scan_pose: optional(isPose),
    believed_scan_pose: optional(isPose),
    ranges: optional(isListOf(oneOf(isNumber, isNull))),
    angle_min: optional(isNumber),
    angle_increment: optional(isNumber),
    bearings: optional(isListOf(isNumber)),
    beam_width: optional(isNumber),
    range_max: optional(isNumber),
    t: isNumber,
    playing: isFlag,
    speed: isNumber,
    index: isInteger,
    count: isInteger,
    stamp: isNumber,
    pose: isPose,
    sensor_pose: isPose,
    auto: isFlag,
    believed_pose: optional(isPose),
    remade_ms: optional(isNumber),
  },
  trajectory: {
    name: isText,
    frame: oneOf(isText, isNull),
    every: isInteger,
    poses: isListOf(isPoint),
    stamps: isListOf(isNumber),
  },
  trajectories: {
    trajectories: isListOf(isTrajectoryInfo),
    compared: oneOf(isTuple(isText, isText), isNull),
  },
  parameters: {
    values: isValues,
    sensor: oneOf(isValues, isNull),
    faults: optional(isValues),
    compare: optional(oneOf(isCompared, isNull)),
  },
  world: {
    name: isText,
    title: isText,
    names: isListOf(isText),
    bounds: isTuple(isNumber, isNumber, isNumber, isNumber),
    polygons: isListOf(isListOf(isPoint)),
    ids: isListOf(isInteger),
    edits: isEdits,
    polished: isListOf(isSegment),
    blocks: optional(isListOf(isBlock)),
  },
  forgetting: {
    cells: isInteger,
    scans: isInteger,
    with_clamp: oneOf(isInteger, isNull),
    without_clamp: oneOf(isInteger, isNull),
    free_with_clamp: isNumber,
    free_without_clamp: isNumber,
  },
  working: {
    elapsed_s: oneOf(isNumber, isNull),
    fraction: oneOf(isNumber, isNull),
    what: optional(isText),
  },
  notice: {
    code: isText,
    message: isText,
  },
  error: {
    code: isText,
    message: isText,
    detail: optional(isNull),
  },
  cell: {
    row: isInteger,
    col: isInteger,
    epoch: isInteger,
    x: isNumber,
    y: isNumber,
    observed: isFlag,
    log_odds: isNumber,
    p_occ: isNumber,
    state: isCellState,
    layer: isText,
  },
  why: {
    row: isInteger,
    col: isInteger,
    epoch: isInteger,
    index: isInteger,
    log_odds: isNumber,
    prior: isNumber,
    log_odds_min: oneOf(isNumber, isNull),
    log_odds_max: oneOf(isNumber, isNull),
    per_scan: isFlag,
    total: isInteger,
    hits: isInteger,
    outweighed: isInteger,
    first_scan: oneOf(isInteger, isNull),
    curve: isListOf(isTuple(isInteger, isNumber)),
    contributions: isListOf(isContribution),
    layer: isText,
  },
  picked: {
    what: isLiteral("cell", "loop", "pose"),
    x: isNumber,
    y: isNumber,
    yaw: oneOf(isNumber, isNull),
    index: oneOf(isInteger, isNull),
    edge: oneOf(isInteger, isNull),
  },
  place: {
    x: isNumber,
    y: isNumber,
    z: oneOf(isNumber, isNull),
    size: oneOf(isNumber, isNull),
  },
  scene: {
    cameras: isListOf(oneOf(isLiteral("above", "east", "north", "overview", "south", "west"), isLiteral("first person", "follow"))),
    layers: isRecordOf(isFlag),
    height: isNumber,
    grid: isNumber,
  },
  pong: {
    id: isInteger,
    t: isNumber,
  },
  comparison: {
    index: isInteger,
    refused: oneOf(isText, isNull),
    numbers: oneOf(isNumbers, isNull),
  },
  localization: {
    is_on: isFlag,
    map: isText,
    values: isValues,
    pose: oneOf(isPose, isNull),
    at: oneOf(isPose, isNull),
    covariance: oneOf(isTuple(isNumber, isNumber, isNumber, isNumber), isNull),
    is_converged: isFlag,
    is_sure: isFlag,
    share: isNumber,
    fit: isNumber,
    entropy: isNumber,
    n_particles: isInteger,
    n_updates: isInteger,
    error_m: oneOf(isNumber, isNull),
    error_rad: oneOf(isNumber, isNull),
  },
  map3d: {
    is_on: isFlag,
    values: isValues,
    scans: isInteger,
    taken: isInteger,
    only_in_3d: isInteger,
    problem: oneOf(isText, isNull),
    known: isInteger,
    nodes: isInteger,
    leaves: isInteger,
    octree_bytes: isInteger,
    block_bytes: isInteger,
    dense_bytes: isInteger,
  },
  volume: {
    look: isTable,
    low: isPlace,
    high: isPlace,
    has_scans: isFlag,
    has_free: isFlag,
    up: isText,
    points: isInteger,
    left_out: isInteger,
    occupied: isInteger,
    free: isInteger,
    bytes: isInteger,
    dense_bytes: isNumber,
    nodes: oneOf(isInteger, isNull),
    chunks: isInteger,
    quads: isInteger,
    pending: isInteger,
    colours: isListOf(isText),
    scale: oneOf(isColourScale, isNull),
    compared: oneOf(isVolumeChanges, isNull),
  },
  surface: {
    table: isListOf(isParameter),
    values: isValues,
    truncation: isNumber,
    index: isInteger,
    blocks: isInteger,
    bytes: isInteger,
    triangles: isInteger,
    chunks: isInteger,
    pending: isInteger,
    snapshots: isListOf(isInteger),
    problem: oneOf(isText, isNull),
  },
  surface_voxel: {
    centre: oneOf(isPlace, isNull),
    size: isNumber,
    distance: oneOf(isNumber, isNull),
    weight: isNumber,
    index: isInteger,
    total: isInteger,
    updates: isListOf(isSurfaceUpdate),
  },
  voxel: {
    centre: oneOf(isPlace, isNull),
    size: isNumber,
    log_odds: oneOf(isNumber, isNull),
    state: isCellState,
    index: isInteger,
    total: isInteger,
    hits: isInteger,
    updates: isListOf(isVoxelUpdate),
    point: optional(oneOf(isVoxelPoint, isNull)),
  },
  terrain: {
    is_on: isFlag,
    values: isValues,
    points: isInteger,
    ground: isInteger,
    unsure: isInteger,
    left_out: isInteger,
    kappa: oneOf(isNumber, isNull),
    total_error: oneOf(isNumber, isNull),
    truth: oneOf(isText, isNull),
    safe: isInteger,
    unsafe: isInteger,
    unknown: isInteger,
    size: isNumber,
    before: oneOf(isTerrainCounts, isNull),
    patch: oneOf(isTerrainPatch, isNull),
    problem: oneOf(isText, isNull),
  },
  costmap: {
    is_on: isFlag,
    values: isValues,
    footprint: isListOf(isPoint),
    inscribed_radius: isNumber,
    circumscribed_radius: isNumber,
    keepout: isListOf(isBrushStroke),
  },
  cost: {
    x: isNumber,
    y: isNumber,
    layers: isListOf(isLayerCost),
    speed: oneOf(isText, isNull),
  },
  nav2: {
    text: oneOf(isText, isNull),
  },
  path: {
    goal: oneOf(isPoint, isNull),
    drives: isFlag,
    length: oneOf(isNumber, isNull),
    cost: oneOf(isNumber, isNull),
    travel_s: oneOf(isNumber, isNull),
    reaches_goal: isFlag,
    reason: oneOf(isText, isNull),
    carrot: oneOf(isPoint, isNull),
    plan_ms: isNumber,
    speed_limit: oneOf(isText, isNull),
  },
  map_edits: {
    n: isInteger,
    undone: isInteger,
    last: isListOf(isText),
    keepout_cells: isInteger,
    speed_cells: isInteger,
    notes: isListOf(isText),
  },
  notes: {
    changed_s: isNumber,
  },
};

/** The same of the messages of a class. */
export const CLASS_FIELDS: Readonly<Record<ClassMessage["type"], Readonly<Record<string, Check>>>> = {
  class: {
    code: isText,
    present: isInteger,
    is_locked: isFlag,
    has_ended: isFlag,
    hands: isListOf(isInteger),
    driver: oneOf(isInteger, isNull),
    question: oneOf(isClassQuestion, isNull),
    puzzle: optional(oneOf(isClassPuzzle, isNull)),
    is_lecturer_away: optional(isFlag),
    counts_joined_only: optional(isFlag),
  },
  welcome: {
    role: isLiteral("follower", "lecturer"),
    number: isInteger,
    answer: oneOf(isNumber, isNull),
  },
  view: {
    view: isClassView,
    stage: isInteger,
  },
  explained: {
    why: oneOf(isWhyMessage, isNull),
  },
  refused: {
    code: isText,
    message: isText,
    answer: optional(oneOf(isNumber, isNull)),
  },
};

/** The sentence that the page shows when the server closes the connection with one of these codes. */
export const CLOSE_SENTENCES: Readonly<Record<number, string>> = {
  1008: "The server closed the connection because this page sent something that is not allowed or too much of it.",
  1009: "The server closed the connection because this page sent a message that is too long.",
  1011: "The server closed the connection because of a defect in the service.",
  1012: "The server does not answer.",
  4401: "This browser has signed out: open the address that has the service\u2019s token.",
  4404: "The server refused the connection: the session does not exist any more, or too many browsers watch it.",
  4408: "The server closed the connection because this page did not answer for a long time.",
  4410: "This session has ended.",
};

/** Close codes after which the session may not exist any more. */
export const MAYBE_OVER: readonly number[] = [4404, 4410];

/** The close code of a session's own stream after which the session does not exist. */
export const ENDED = 4410;
