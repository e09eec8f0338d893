/**
 * The bodies of frames with a table, and with a graph. The arrays are views into the frame: its numbers are
 * little-endian, as those of all machines on which browsers run.
 */

import { ProtocolError } from "./protocol";

const TABLE_HEADER_BYTES = 4;
const GRAPH_HEADER_BYTES = 8;

export interface TableBody {
  readonly kind: "table";
  /** In the order of the layer's `columns`, all of one length. NaN is no value. */
  readonly columns: readonly Float32Array[];
}

export interface GraphBody {
  readonly kind: "graph";
  /** The table of the nodes. */
  readonly columns: readonly Float32Array[];
  /** The indices of the two nodes of each edge in the table. */
  readonly edges: Uint32Array;
  /** The value of each edge. */
  readonly values: Float32Array;
}

/** Read the columns of `count` points from the byte `at` on. Throws {@link ProtocolError} for another size of it. */
export function decodeTable(view: DataView<ArrayBuffer>, at: number, count: number): TableBody {
  checkSize(view, at + TABLE_HEADER_BYTES);
  const columns = view.getUint16(at, true);
  checkSize(view, at + TABLE_HEADER_BYTES, 4 * columns * count);
  return { kind: "table", columns: columnsOf(view.buffer, at + TABLE_HEADER_BYTES, columns, count) };
}

/** Read the `count` nodes and the edges of a graph. Throws as {@link decodeTable}, and for an edge without its nodes. */
export function decodeGraph(view: DataView<ArrayBuffer>, at: number, count: number): GraphBody {
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

/** The frame has `first` bytes and then exactly `rest`, or any number of them. */
export function checkSize(view: DataView, first: number, rest?: number): void {
  const size = view.byteLength;
  if (size < first + (rest ?? 0)) {
    throw new ProtocolError("frame.cut", `The frame states ${first + (rest ?? 0)} bytes and has ${size}.`);
  }
  if (rest !== undefined && size > first + rest) {
    throw new ProtocolError("frame.rest", `${size - first - rest} bytes follow the content.`);
  }
}
