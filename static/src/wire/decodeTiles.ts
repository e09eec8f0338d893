/** The body of a frame of tiles. */

import { ProtocolError } from "./protocol";

const TILE_HEADER_BYTES = 12;

/** One compressed tile; `data` is a view into the frame. */
export interface TilePayload {
  readonly tx: number;
  readonly ty: number;
  readonly revision: number;
  readonly data: Uint8Array;
}

export interface TilesBody {
  readonly kind: "tiles";
  readonly tiles: readonly TilePayload[];
}

/** Read `count` tiles from the byte `at` on. Throws {@link ProtocolError} for a body that is cut or too long. */
export function decodeTiles(view: DataView<ArrayBuffer>, at: number, count: number): TilesBody {
  const size = view.byteLength;
  const tiles: TilePayload[] = [];
  for (let i = 0; i < count; i++) {
    if (at + TILE_HEADER_BYTES > size) {
      throw new ProtocolError("frame.cut", `The frame states ${count} tiles and ends after ${i}.`);
    }
    const tx = view.getInt16(at, true);
    const ty = view.getInt16(at + 2, true);
    const revision = view.getUint32(at + 4, true);
    const nbytes = view.getUint32(at + 8, true);
    at += TILE_HEADER_BYTES;
    if (at + nbytes > size) {
      throw new ProtocolError("frame.cut", `Tile (${tx}, ${ty}) states ${nbytes} bytes; ${size - at} are left.`);
    }
    tiles.push({ tx, ty, revision, data: new Uint8Array(view.buffer, at, nbytes) });
    at += nbytes;
  }
  if (at !== size) throw new ProtocolError("frame.rest", `${size - at} bytes follow the last tile.`);
  return { kind: "tiles", tiles };
}
