/** The binary frames of the stream: compressed tiles of the map. */

import { ProtocolError } from "./protocol";

const KIND_TILES = 1;
const FLAG_COMPLETE = 1;
const HEADER_BYTES = 16;
const TILE_HEADER_BYTES = 12;

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
