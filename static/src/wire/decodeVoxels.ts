/** The drawn faces of a chunk of voxels; the layout is described in server/scenes/voxel_chunk.py. */

export const CHUNK = 32;
const MAGIC = 0x58564247; // "GBVX"
const HEADER_BYTES = 16;

/** Faces of the voxels x + 32 y + 1024 z of a chunk. */
export interface VoxelChunk {
  /** For each voxel the sides of its faces as bits: −x, +x, −y, +y, −z, +z. */
  readonly sides: Uint8Array;
  /** For each voxel with faces the number of its colour, from 0. */
  readonly numbers: Uint8Array;
  /** Number of colours. */
  readonly colours: number;
  /** Colours of faces by side, number and channel: linear RGB. */
  readonly table: Uint8Array;
}

/** Whether the bytes have the signature of a chunk of voxels. */
export function isVoxelChunk(data: Uint8Array): boolean {
  return data.length >= HEADER_BYTES && new DataView(data.buffer, data.byteOffset).getUint32(0, true) === MAGIC;
}

/** Read a chunk of voxels. Throws {@link RangeError} if its parts do not have the stated lengths. */
export function decodeVoxels(data: Uint8Array): VoxelChunk {
  if (!isVoxelChunk(data)) throw new RangeError("These bytes are not a chunk of voxels.");
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const [colours, pairs, count] = [view.getUint32(4, true), view.getUint32(8, true), view.getUint32(12, true)];
  const firstPair = HEADER_BYTES + 18 * colours;
  const firstNumber = firstPair + 2 * pairs;
  if (firstNumber + count !== data.length) {
    throw new RangeError(`A chunk of ${firstNumber + count} bytes has ${data.length}.`);
  }
  const sides = new Uint8Array(CHUNK ** 3);
  const numbers = new Uint8Array(CHUNK ** 3);
  let voxel = 0;
  let number = 0;
  let read = 0;
  for (let at = firstPair; at < firstNumber; at += 2) {
    voxel += data[at] as number;
    const bits = data[at + 1] as number;
    if (bits === 0) continue;
    if (voxel >= sides.length || read === count) {
      throw new RangeError("A chunk has more voxels than it states or has room for.");
    }
    number = (number + (data[firstNumber + read++] as number)) & 255;
    if (number >= colours) throw new RangeError(`A voxel has colour ${number} of ${colours}.`);
    sides[voxel] = bits;
    numbers[voxel++] = number;
  }
  if (read !== count) throw new RangeError(`Of ${count} voxels of a chunk ${read} have faces.`);
  return { sides, numbers, colours, table: data.subarray(HEADER_BYTES, firstPair) };
}
