/** The text frames of the stream: JSON, of which every field that the pages rely on is looked at. */

import { ProtocolError, type ServerMessage, TILE } from "./protocol";

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

const isCompared: Check = (value) => {
  const { states, only, entropy_bits, contrast, ...rest } = (value ?? {}) as Record<string, unknown>;
  const isTable = Array.isArray(states) && states.length === 3 && states.every(isNumbers(3));
  const scalars = ["cells", "same", "both", "mean_difference", "max_difference"];
  return isTable && [only, entropy_bits, contrast].every(isNumbers(2)) && scalars.every((name) => isNumber(rest[name]));
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
  comparison: {
    index: isNumber,
    refused: orNull(isText),
    numbers: orNull(isCompared),
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
  working: { elapsed_s: orNull(isNumber), fraction: orNull(isNumber) },
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
