/** The binary frames of the stream: a header, and a body that the decoder of the frame's kind reads. */

import { type ChangesBody, decodeChanges } from "./decodeChanges";
import { decodeGraph, decodeTable, type GraphBody, type TableBody } from "./decodeTable";
import { decodeTiles, type TilesBody } from "./decodeTiles";
import { ProtocolError } from "./protocol";

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

/** Read a binary frame. Throws {@link ProtocolError} for one that is cut or of an unknown kind. */
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
