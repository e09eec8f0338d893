/** The body of a frame with changes of single cells. The arrays are views into the frame, as those of a table. */

import { checkSize } from "./decodeTable";
import { ProtocolError, TILE } from "./protocol";

const REVISION_BYTES = 4;
const TILE_HEADER_BYTES = 8;

/** The changed cells of one tile. */
export interface TileChanges {
  readonly tx: number;
  readonly ty: number;
  /** Of each cell row · 64 + column within the tile. */
  readonly places: Uint16Array;
  /** Of each cell its new value, int8. */
  readonly values: Uint8Array;
}

export interface ChangesBody {
  readonly kind: "changes";
  /** Of all these tiles, with the changes. */
  readonly revision: number;
  readonly tiles: readonly TileChanges[];
}

/** Read the changes of `count` tiles from the byte `at` on. Throws {@link ProtocolError} for another size of them. */
export function decodeChanges(view: DataView<ArrayBuffer>, at: number, count: number): ChangesBody {
  const first = at + REVISION_BYTES;
  const places = first + TILE_HEADER_BYTES * count;
  checkSize(view, places);
  let cells = 0;
  for (let i = 0; i < count; i++) cells += view.getUint16(first + TILE_HEADER_BYTES * i + 4, true);
  checkSize(view, places, 3 * cells);
  const allPlaces = new Uint16Array(view.buffer, places, cells);
  if (allPlaces.some((place) => place >= TILE * TILE)) {
    throw new ProtocolError("frame.cell", `A tile has ${TILE * TILE} cells.`);
  }
  const allValues = new Uint8Array(view.buffer, places + 2 * cells, cells);
  let from = 0;
  const tiles = Array.from({ length: count }, (_, i): TileChanges => {
    const header = first + TILE_HEADER_BYTES * i;
    const to = from + view.getUint16(header + 4, true);
    const part = { places: allPlaces.subarray(from, to), values: allValues.subarray(from, to) };
    from = to;
    return { tx: view.getInt16(header, true), ty: view.getInt16(header + 2, true), ...part };
  });
  return { kind: "changes", revision: view.getUint32(at, true), tiles };
}
