/**
 * The wire's words: every message and command. Their twin is `server/stream/protocol.py`, where each is described; they
 * are read by `decodeText.ts` and `decodeTiles.ts`. `protocol.vectors.json` is written by the server's side and read by
 * the tests of this one.
 */

export const SUBPROTOCOL = "gridbloom.v1";
/** Cells along the side of a tile. */
export const TILE = 64;

export type Pose = readonly [x: number, y: number, yaw: number];
export type Point = readonly [x: number, y: number];
export type Value = number | string | boolean;
export type Values = Readonly<Record<string, Value>>;

/** One row of the mapper's table of parameters. */
export interface Parameter {
  readonly name: string;
  readonly label: string;
  readonly group: string;
  readonly kind: "number" | "choice" | "flag";
  readonly initial: Value;
  readonly sentence: string;
  readonly unit: string;
  readonly low: number;
  readonly high: number;
  readonly step: number;
  readonly choices: readonly string[];
  readonly only_for: readonly string[];
}

export interface Table {
  readonly table: readonly Parameter[];
  readonly values: Values;
}

export interface LogInfo {
  readonly id: string;
  readonly trajectory: string;
  readonly trajectories: readonly { readonly name: string; readonly description: string }[];
  readonly n_beams: number;
  /** The recorded time; 0 for a log without times. */
  readonly duration_s: number;
  /** What was noticed while it was read, a sentence each. */
  readonly notes: readonly string[];
}

export interface Hello {
  readonly type: "hello";
  readonly protocol: string;
  readonly session: string;
  readonly kind: "world" | "log";
  readonly title: string;
  readonly epoch_id: string;
  /** The least and the greatest speed. */
  readonly speeds: readonly [number, number];
  readonly parameters: Table;
  readonly sensor: Table | null;
  readonly log: LogInfo | null;
  /** Of a live world: the same seed and the same commands give the same scans. */
  readonly seed?: number;
}

export interface Geometry {
  readonly type: "geometry";
  readonly epoch: number;
  readonly resolution: number;
  readonly rows: number;
  readonly cols: number;
  readonly origin: Pose;
  readonly log_odds_min: number;
  readonly log_odds_max: number;
  readonly tile: number;
}

/** What the robot sees: the part of a frame that is sent only with a new scan. */
export interface Seen {
  /** Where the sensor was when it measured `ranges`. */
  readonly scan_pose: Pose;
  /** The same where the map has it, only while the robot drifts. */
  readonly believed_scan_pose?: Pose;
  readonly ranges: readonly (number | null)[];
  readonly angle_min: number;
  readonly angle_increment: number;
  /** Bearing of each beam where they are not even: sonars. */
  readonly bearings?: readonly number[];
  /** Angle of the sonars' cones, radians; a lidar's beams have none. */
  readonly beam_width?: number;
  readonly range_max: number;
}

/** A frame as it comes: without a scan where that is the same as before. */
export type FrameMessage = Omit<Frame, keyof Seen> & Partial<Seen>;

export interface Frame extends Seen {
  readonly type: "frame";
  readonly t: number;
  readonly playing: boolean;
  readonly speed: number;
  readonly index: number;
  readonly count: number;
  readonly stamp: number;
  readonly pose: Pose;
  readonly sensor_pose: Pose;
  /** `pose` where the map has it, only while the robot drifts. */
  readonly believed_pose?: Pose;
  readonly remade_ms?: number;
  readonly auto: boolean;
}

/** Where the base was at each scan, of very long logs at each `every`-th. */
export interface Trajectory {
  readonly type: "trajectory";
  readonly name: string;
  readonly every: number;
  readonly poses: readonly Point[];
  /** How much of the recorded time is over then, in seconds. */
  readonly stamps: readonly number[];
}

export interface WorldMessage {
  readonly type: "world";
  readonly name: string;
  readonly title: string;
  readonly names: readonly string[];
  readonly bounds: readonly [number, number, number, number];
  readonly polygons: readonly (readonly Point[])[];
  /** Which solid of the world as it was built each polygon is, or −1 − its place among the added ones. */
  readonly ids: readonly number[];
  readonly edits: Edits;
  /** Faces that swallow beams while the fault `specular` is on: ax, ay, bx, by. */
  readonly polished: readonly (readonly [number, number, number, number])[];
}

/** A wall from corner to corner, or an upright box; whole centimetres. */
export type Drawn = readonly [kind: "wall" | "box", x0: number, y0: number, x1: number, y1: number];

/** What a person changed in a world as it was built. */
export interface Edits {
  readonly added: readonly Drawn[];
  readonly erased: readonly number[];
}

/** What takes the server longer than a moment to compute: since when, and how much of it is done where that is known. */
export interface WorkingMessage {
  readonly type: "working";
  /** Null: nothing is being computed any more. */
  readonly elapsed_s: number | null;
  readonly fraction: number | null;
}

/** How far two maps, one clamped and one not, have forgotten what was erased; without cells nothing is watched. */
export interface Forgetting {
  readonly type: "forgetting";
  readonly cells: number;
  readonly scans: number;
  /** Scans after which 9 in 10 of the cells were free, null while they are not. */
  readonly with_clamp: number | null;
  readonly without_clamp: number | null;
  readonly free_with_clamp: number;
  readonly free_without_clamp: number;
}

/** What the second map has otherwise than the first. */
export interface Compared {
  readonly values: Values;
  readonly with_faults: boolean;
  /** Of a log's other side: the poses it is made with. */
  readonly trajectory?: string;
  /** Of a log's other side: which log it is of, null for the session's own. */
  readonly log?: string | null;
  readonly topic?: string | null;
  readonly title?: string;
}

/** How a log's map, b, differs from its other side, a; pairs are [a, b]. As `Comparison` of mapper/grid/compare.py has it. */
export interface Numbers {
  readonly cells: number;
  /** Cells by state in a, then in b: free, occupied, unknown. */
  readonly states: readonly (readonly number[])[];
  readonly same: number;
  readonly only: readonly [a: number, b: number];
  readonly both: number;
  readonly entropy_bits: readonly [a: number, b: number];
  readonly contrast: readonly [a: number, b: number];
  readonly mean_difference: number;
  readonly max_difference: number;
  readonly max_at: Point | null;
}

/** The two maps in numbers, or why there are none; neither where nothing is compared. */
export interface ComparisonMessage {
  readonly type: "comparison";
  readonly index: number;
  readonly refused: string | null;
  readonly numbers: Numbers | null;
}

/** Which of a session's maps a question or an answer is about; the first where nothing is said. */
export type Which = "first" | "second";

export interface ParametersMessage {
  readonly type: "parameters";
  readonly values: Values;
  readonly sensor: Values | null;
  readonly faults?: Values;
  readonly compare?: Compared | null;
}

export interface CellMessage {
  readonly type: "cell";
  readonly row: number;
  readonly col: number;
  readonly epoch: number;
  readonly x: number;
  readonly y: number;
  readonly observed: boolean;
  readonly log_odds: number;
  readonly p_occ: number;
  readonly state: CellState;
  readonly map?: Which;
}

/** One beam that touched a cell: touch `n`, from 1, is beam `beam` of scan `scan`, from 0. */
export interface Touch {
  readonly n: number;
  readonly scan: number;
  readonly stamp: number;
  readonly beam: number;
  /** Where the sensor was, T_map_laser. */
  readonly pose: Pose;
  readonly bearing: number;
  /** Metres; null for no return. */
  readonly range: number | null;
  readonly hit: boolean;
  readonly increment: number;
  /** What the cell held after it. */
  readonly log_odds: number;
}

/** Why a cell is what it is, in the map of `index` scans. */
export interface WhyMessage {
  readonly type: "why";
  readonly row: number;
  readonly col: number;
  readonly epoch: number;
  readonly index: number;
  readonly map?: Which;
  readonly log_odds: number;
  readonly prior: number;
  readonly log_odds_min: number | null;
  readonly log_odds_max: number | null;
  readonly per_scan: boolean;
  readonly total: number;
  readonly hits: number;
  readonly first_scan: number | null;
  /** The running log-odds over all touches, thinned. */
  readonly curve: readonly (readonly [n: number, log_odds: number])[];
  readonly touches: readonly Touch[];
}

export type CellState = "free" | "unknown" | "occupied";

export type ServerMessage =
  | Hello
  | Geometry
  | FrameMessage
  | Forgetting
  | ComparisonMessage
  | WorldMessage
  | CellMessage
  | WhyMessage
  | Trajectory
  | ParametersMessage
  | WorkingMessage
  | { readonly type: "notice"; readonly code: string; readonly message: string }
  | { readonly type: "error"; readonly code: string; readonly message: string; readonly detail?: unknown }
  | { readonly type: "pong"; readonly id: number; readonly t: number };

export type Command =
  | { readonly type: "ack"; readonly seq: number }
  | { readonly type: "resume"; readonly epoch_id: string; readonly epoch: number; readonly revision: number }
  | { readonly type: "play" | "pause" | "restart" }
  | { readonly type: "step"; readonly scans?: number }
  | { readonly type: "speed"; readonly value: number }
  | { readonly type: "seek"; readonly index: number }
  | { readonly type: "parameters" | "sensor"; readonly values: Values }
  | { readonly type: "teleport"; readonly x: number; readonly y: number; readonly yaw?: number }
  | { readonly type: "drive"; readonly linear: number; readonly angular: number }
  | { readonly type: "auto"; readonly value: boolean }
  | { readonly type: "faults"; readonly values: Values }
  | { readonly type: "compare"; readonly values: Values | null }
  | ({ readonly type: "edit"; readonly watch?: boolean } & Edits)
  | ({ readonly type: "world"; readonly name: string } & Partial<Edits>)
  | { readonly type: "trajectory"; readonly name: string }
  | {
      readonly type: "inspect";
      readonly row: number;
      readonly col: number;
      readonly epoch: number;
      readonly map?: Which;
    }
  | {
      readonly type: "why";
      readonly row: number;
      readonly col: number;
      readonly epoch: number;
      readonly until?: number;
      readonly map?: Which;
    }
  | { readonly type: "ping"; readonly id: number };

/** A frame that breaks the protocol; `code` is stable, the message is one sentence. */
export class ProtocolError extends Error {
  readonly code: string;

  constructor(code: string, message: string) {
    super(message);
    this.name = "ProtocolError";
    this.code = code;
  }
}

/** Write a command. */
export function encodeCommand(command: Command): string {
  return JSON.stringify(command);
}
