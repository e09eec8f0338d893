/** The binary frames of the stream: a header, and a body that is decoded according to the frame's kind. */

import { ProtocolError, TILE } from "./protocol";

const TABLE_HEADER_BYTES = 4;
const GRAPH_HEADER_BYTES = 8;

interface TableBody {
  readonly kind: "table";
  /** In the order of the layer's `columns`, all of the same length. NaN means no value. */
  readonly columns: readonly Float32Array[];
}

interface GraphBody {
  readonly kind: "graph";
  /** The table of the nodes. */
  readonly columns: readonly Float32Array[];
  /** The indices of the two nodes of each edge in the table. */
  readonly edges: Uint32Array;
  /** The value of each edge. */
  readonly values: Float32Array;
}

/** Read the columns of `count` points from the byte `at` on. Throws {@link ProtocolError} for a wrong size. */
function decodeTable(view: DataView<ArrayBuffer>, at: number, count: number): TableBody {
  checkSize(view, at + TABLE_HEADER_BYTES);
  const columns = view.getUint16(at, true);
  checkSize(view, at + TABLE_HEADER_BYTES, 4 * columns * count);
  return { kind: "table", columns: columnsOf(view.buffer, at + TABLE_HEADER_BYTES, columns, count) };
}

/** Read the `count` nodes and the edges of a graph. Throws like {@link decodeTable}, and for a missing node. */
function decodeGraph(view: DataView<ArrayBuffer>, at: number, count: number): GraphBody {
  checkSize(view, at + GRAPH_HEADER_BYTES);
  const columns = view.getUint16(at, true);
  const edges = view.getUint32(at + 4, true);
  const first = at + GRAPH_HEADER_BYTES;
  const nodes = 4 * columns * count;
  checkSize(view, first, nodes + 12 * edges);
  const ends = new Uint32Array(view.buffer, first + nodes, 2 * edges);
  for (const end of ends) {
    if (end >= count) throw new ProtocolError("frame.edge", `An edge ends at node ${end} of ${count}.`);
  }
  return {
    kind: "graph",
    columns: columnsOf(view.buffer, first, columns, count),
    edges: ends,
    values: new Float32Array(view.buffer, first + nodes + 8 * edges, edges),
  };
}

function columnsOf(buffer: ArrayBuffer, first: number, columns: number, count: number): Float32Array[] {
  return Array.from({ length: columns }, (_, i) => new Float32Array(buffer, first + 4 * count * i, count));
}

/** Check that the frame has `first` bytes followed by exactly `rest`, or by any number. */
function checkSize(view: DataView, first: number, rest?: number): void {
  const size = view.byteLength;
  if (size < first + (rest ?? 0)) {
    throw new ProtocolError("frame.cut", `The frame states ${first + (rest ?? 0)} bytes and has ${size}.`);
  }
  if (rest !== undefined && size > first + rest) {
    throw new ProtocolError("frame.rest", `${size - first - rest} bytes follow the content.`);
  }
}

const REVISION_BYTES = 4;
const CHANGES_HEADER_BYTES = 8;

/** The changed cells of one tile. */
interface TileChanges {
  readonly tx: number;
  readonly ty: number;
  /** For each cell row · 64 + column within the tile. */
  readonly places: Uint16Array;
  /** For each cell its new value, int8. */
  readonly values: Uint8Array;
}

interface ChangesBody {
  readonly kind: "changes";
  /** Of all these tiles, after the changes. */
  readonly revision: number;
  readonly tiles: readonly TileChanges[];
}

/** Read the changes of `count` tiles from the byte `at` on. Throws {@link ProtocolError} for a wrong size. */
function decodeChanges(view: DataView<ArrayBuffer>, at: number, count: number): ChangesBody {
  const first = at + REVISION_BYTES;
  const places = first + CHANGES_HEADER_BYTES * count;
  checkSize(view, places);
  let cells = 0;
  for (let i = 0; i < count; i++) cells += view.getUint16(first + CHANGES_HEADER_BYTES * i + 4, true);
  checkSize(view, places, 3 * cells);
  const allPlaces = new Uint16Array(view.buffer, places, cells);
  if (allPlaces.some((place) => place >= TILE * TILE)) {
    throw new ProtocolError("frame.cell", `A tile has ${TILE * TILE} cells.`);
  }
  const allValues = new Uint8Array(view.buffer, places + 2 * cells, cells);
  let from = 0;
  const tiles = Array.from({ length: count }, (_, i): TileChanges => {
    const header = first + CHANGES_HEADER_BYTES * i;
    const to = from + view.getUint16(header + 4, true);
    const part = { places: allPlaces.subarray(from, to), values: allValues.subarray(from, to) };
    from = to;
    return { tx: view.getInt16(header, true), ty: view.getInt16(header + 2, true), ...part };
  });
  return { kind: "changes", revision: view.getUint32(at, true), tiles };
}

const PAYLOAD_HEADER_BYTES = 12;

/** One compressed tile; `data` is a view into the frame. */
interface TilePayload {
  readonly tx: number;
  readonly ty: number;
  readonly revision: number;
  readonly data: Uint8Array;
}

interface TilesBody {
  readonly kind: "tiles";
  readonly tiles: readonly TilePayload[];
}

/** Read `count` tiles from the byte `at` on. Throws {@link ProtocolError} for a body that is truncated or too long. */
function decodeTiles(view: DataView<ArrayBuffer>, at: number, count: number): TilesBody {
  const size = view.byteLength;
  const tiles: TilePayload[] = [];
  for (let i = 0; i < count; i++) {
    if (at + PAYLOAD_HEADER_BYTES > size) {
      throw new ProtocolError("frame.cut", `The frame states ${count} tiles and ends after ${i}.`);
    }
    const tx = view.getInt16(at, true);
    const ty = view.getInt16(at + 2, true);
    const revision = view.getUint32(at + 4, true);
    const nbytes = view.getUint32(at + 8, true);
    at += PAYLOAD_HEADER_BYTES;
    if (at + nbytes > size) {
      throw new ProtocolError("frame.cut", `Tile (${tx}, ${ty}) states ${nbytes} bytes; ${size - at} are left.`);
    }
    tiles.push({ tx, ty, revision, data: new Uint8Array(view.buffer, at, nbytes) });
    at += nbytes;
  }
  if (at !== size) throw new ProtocolError("frame.rest", `${size - at} bytes follow the last tile.`);
  return { kind: "tiles", tiles };
}

const FLAG_COMPLETE = 1;
const HEADER_BYTES = 16;

interface Header {
  /** Id of the layer; 0 for none. */
  readonly layer: number;
  /** The epoch of the geometry for tiles, a sequence number for other content. */
  readonly epoch: number;
  readonly seq: number;
  /** Whether the layer is complete with this frame. */
  readonly complete: boolean;
}

export type TilesFrame = Header & TilesBody;
export type ChangesFrame = Header & ChangesBody;
export type BinaryFrame = Header & (TilesBody | ChangesBody | TableBody | GraphBody);

type Decoder = (
  view: DataView<ArrayBuffer>,
  at: number,
  count: number,
) => TilesBody | ChangesBody | TableBody | GraphBody;

/** By the number in the header. */
const DECODERS: Readonly<Record<number, Decoder>> = {
  1: decodeTiles,
  2: decodeTable,
  3: decodeGraph,
  4: decodeChanges,
};

/** Read a binary frame. Throws {@link ProtocolError} for one that is truncated or of an unknown kind. */
export function decodeFrame(buffer: ArrayBuffer): BinaryFrame {
  const size = buffer.byteLength;
  if (size < HEADER_BYTES) {
    throw new ProtocolError("frame.cut", `A binary frame has at least ${HEADER_BYTES} bytes, this one ${size}.`);
  }
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  const decode = DECODERS[kind];
  if (!decode) throw new ProtocolError("frame.kind", `There are no binary frames of kind ${kind}.`);
  return {
    layer: view.getUint16(2, true),
    epoch: view.getUint32(4, true),
    seq: view.getUint32(8, true),
    complete: (view.getUint8(1) & FLAG_COMPLETE) !== 0,
    ...decode(view, HEADER_BYTES, view.getUint32(12, true)),
  };
}
