/**
 * The wire: what the stream's frames look like, decoded and encoded once. Its twin is `server/stream/protocol.py`,
 * where every message is described; `protocol.vectors.json` is written by that side and read by the tests of this one.
 */

export const SUBPROTOCOL = "gridbloom.v1";
/** Cells along the side of a tile. */
export const TILE = 64;

const KIND_TILES = 1;
const FLAG_COMPLETE = 1;
const HEADER_BYTES = 16;
const TILE_HEADER_BYTES = 12;

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
  /** The parameters with which a live world begins, where they differ from the table's. */
  readonly initial?: Values;
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
}

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
  | WorldMessage
  | CellMessage
  | WhyMessage
  | Trajectory
  | ParametersMessage
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
  | { readonly type: "inspect"; readonly row: number; readonly col: number; readonly epoch: number }
  | {
      readonly type: "why";
      readonly row: number;
      readonly col: number;
      readonly epoch: number;
      readonly until?: number;
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

/** One compressed tile; `data` is a view into the frame. */
export interface TilePayload {
  readonly tx: number;
  readonly ty: number;
  readonly revision: number;
  readonly data: Uint8Array;
}

export interface TilesFrame {
  readonly epoch: number;
  readonly seq: number;
  /** The last frame of a complete picture: every tile up to the newest revision has been sent. */
  readonly complete: boolean;
  readonly tiles: readonly TilePayload[];
}

/** Read a binary frame. Throws {@link ProtocolError} for one that is cut or of another kind. */
export function decodeTiles(buffer: ArrayBuffer): TilesFrame {
  const size = buffer.byteLength;
  if (size < HEADER_BYTES) {
    throw new ProtocolError("frame.cut", `A binary frame has at least ${HEADER_BYTES} bytes, this one ${size}.`);
  }
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  if (kind !== KIND_TILES) {
    throw new ProtocolError("frame.kind", `Binary frames are of kind ${KIND_TILES}, this one is ${kind}.`);
  }
  const count = view.getUint32(12, true);
  const tiles: TilePayload[] = [];
  let at = HEADER_BYTES;
  for (let i = 0; i < count; i++) {
    if (at + TILE_HEADER_BYTES > size) {
      throw new ProtocolError("frame.cut", `The frame promises ${count} tiles and ends after ${i}.`);
    }
    const tx = view.getInt16(at, true);
    const ty = view.getInt16(at + 2, true);
    const revision = view.getUint32(at + 4, true);
    const nbytes = view.getUint32(at + 8, true);
    at += TILE_HEADER_BYTES;
    if (at + nbytes > size) {
      throw new ProtocolError("frame.cut", `Tile (${tx}, ${ty}) promises ${nbytes} bytes; ${size - at} are left.`);
    }
    tiles.push({ tx, ty, revision, data: new Uint8Array(buffer, at, nbytes) });
    at += nbytes;
  }
  if (at !== size) throw new ProtocolError("frame.rest", `${size - at} bytes follow the last tile.`);
  return {
    epoch: view.getUint32(4, true),
    seq: view.getUint32(8, true),
    complete: (view.getUint8(1) & FLAG_COMPLETE) !== 0,
    tiles,
  };
}

type Check = (value: unknown) => boolean;

const isNumber: Check = (value) => typeof value === "number" && Number.isFinite(value);
const isText: Check = (value) => typeof value === "string";
const isFlag: Check = (value) => typeof value === "boolean";
const isObject: Check = (value) => typeof value === "object" && value !== null && !Array.isArray(value);
const isList: Check = (value) => Array.isArray(value);
const isNumbers = (n: number): Check => {
  return (value) => Array.isArray(value) && value.length === n && value.every(isNumber);
};
const orNull = (check: Check): Check => {
  return (value) => value === null || check(value);
};
const orMissing = (check: Check): Check => {
  return (value) => value === undefined || check(value);
};
const isEdits: Check = (value) => {
  const { added, erased } = (value ?? {}) as Record<string, unknown>;
  return isList(added) && isList(erased);
};
const isTable: Check = (value) => {
  const { table, values } = (value ?? {}) as Record<string, unknown>;
  return isList(table) && isObject(values);
};

/** The fields that the pages rely on; a message may have more. */
const FIELDS: Readonly<Record<ServerMessage["type"], Readonly<Record<string, Check>>>> = {
  hello: {
    session: isText,
    kind: (value) => value === "world" || value === "log",
    title: isText,
    epoch_id: isText,
    speeds: isNumbers(2),
    parameters: isTable,
    sensor: orNull(isTable),
    log: orNull(isObject),
  },
  geometry: {
    epoch: isNumber,
    resolution: (value) => isNumber(value) && (value as number) > 0,
    rows: isNumber,
    cols: isNumber,
    origin: isNumbers(3),
    log_odds_min: isNumber,
    log_odds_max: isNumber,
    tile: (value) => value === TILE,
  },
  frame: {
    t: isNumber,
    playing: isFlag,
    speed: isNumber,
    index: isNumber,
    count: isNumber,
    pose: isNumbers(3),
    sensor_pose: isNumbers(3),
    believed_pose: orMissing(isNumbers(3)),
    ranges: orMissing(isList),
    scan_pose: orMissing(isNumbers(3)),
    believed_scan_pose: orMissing(isNumbers(3)),
    angle_min: orMissing(isNumber),
    angle_increment: orMissing(isNumber),
    bearings: orMissing(isList),
    beam_width: orMissing(isNumber),
    range_max: orMissing(isNumber),
  },
  forgetting: {
    cells: isNumber,
    scans: isNumber,
    with_clamp: orNull(isNumber),
    without_clamp: orNull(isNumber),
    free_with_clamp: isNumber,
    free_without_clamp: isNumber,
  },
  trajectory: { name: isText, every: isNumber, poses: isList, stamps: isList },
  parameters: { values: isObject, sensor: orNull(isObject) },
  world: {
    name: isText,
    title: isText,
    names: isList,
    bounds: isNumbers(4),
    polygons: isList,
    ids: isList,
    edits: isEdits,
    polished: isList,
  },
  notice: { code: isText, message: isText },
  error: { code: isText, message: isText },
  cell: { row: isNumber, col: isNumber, epoch: isNumber, observed: isFlag, log_odds: isNumber, p_occ: isNumber },
  why: {
    row: isNumber,
    col: isNumber,
    epoch: isNumber,
    index: isNumber,
    log_odds: isNumber,
    prior: isNumber,
    log_odds_min: orNull(isNumber),
    log_odds_max: orNull(isNumber),
    per_scan: isFlag,
    total: isNumber,
    hits: isNumber,
    first_scan: orNull(isNumber),
    curve: isList,
    touches: isList,
  },
  pong: { id: isNumber, t: isNumber },
};

/** Read a text frame; null for a type that this page does not know (a newer server). Throws {@link ProtocolError}. */
export function decodeText(text: string): ServerMessage | null {
  let message: unknown;
  try {
    message = JSON.parse(text);
  } catch {
    throw new ProtocolError("message.json", "A text frame is one JSON object; this is not JSON.");
  }
  const { type } = (message ?? {}) as { type?: unknown };
  if (!isObject(message) || typeof type !== "string") {
    throw new ProtocolError("message.type", 'A text frame is a JSON object with a "type".');
  }
  if (!Object.hasOwn(FIELDS, type)) return null;
  const fields = FIELDS[type as ServerMessage["type"]];
  for (const [key, check] of Object.entries(fields)) {
    const value = (message as Record<string, unknown>)[key];
    if (!check(value)) {
      throw new ProtocolError(
        `${type}.${key}`,
        `"${key}" of "${type}" cannot be ${JSON.stringify(value) ?? "missing"}.`,
      );
    }
  }
  return message as ServerMessage;
}

/** Write a command. */
export function encodeCommand(command: Command): string {
  return JSON.stringify(command);
}
