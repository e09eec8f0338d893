/** The faces of a chunk's voxels merged to rectangles, as mapper/volume/kernels/faces.py::merge_faces does. */

import { CHUNK, type VoxelChunk } from "../../wire/decodeVoxels";

/**
 * Side (−x, +x, −y, +y, −z, +z), x, y and z of the first voxel, voxels along the two axes that follow the side's own,
 * number of the colour.
 */
export type Rectangle = readonly [
  side: number,
  x: number,
  y: number,
  z: number,
  wide: number,
  high: number,
  colour: number,
];

const STRIDES = [1, CHUNK, CHUNK * CHUNK] as const;

/** Return the rectangles of a chunk: neighbouring faces of one side, level and colour. */
export function mergeFaces({ sides, numbers }: VoxelChunk): Rectangle[] {
  const rectangles: Rectangle[] = [];
  /** Of a level, the colours of its faces from 1, and 0 where there is none or it is in a rectangle. */
  const plane = new Int16Array(CHUNK * CHUNK);
  const levels = levelsWithFaces(sides);
  for (let side = 0; side < 6; side++) {
    const axis = side >> 1;
    const stride = STRIDES[axis] as number;
    const along = STRIDES[(axis + 1) % 3] as number;
    const across = STRIDES[(axis + 2) % 3] as number;
    for (let level = 0; level < CHUNK; level++) {
      if ((((levels[side] as number) >> level) & 1) === 0) continue;
      for (let b = 0, at = 0; b < CHUNK; b++) {
        for (let voxel = level * stride + b * across, a = 0; a < CHUNK; a++, at++, voxel += along) {
          plane[at] = (((sides[voxel] as number) >> side) & 1) * ((numbers[voxel] as number) + 1);
        }
      }
      mergeLevel(plane, side, level, rectangles);
    }
  }
  return rectangles;
}

/** Return of each side the levels that have faces, as bits: few of 32 in most chunks. */
function levelsWithFaces(sides: Uint8Array): Int32Array {
  const levels = new Int32Array(6);
  for (let voxel = 0; voxel < sides.length; voxel++) {
    const bits = sides[voxel] as number;
    for (let side = 0; bits >> side; side++) {
      const level = (voxel >> (5 * (side >> 1))) & (CHUNK - 1);
      levels[side] = (levels[side] as number) | (((bits >> side) & 1) << level);
    }
  }
  return levels;
}

/** Add the rectangles of one level, each as wide as it can be and then as high, and empty the plane. */
function mergeLevel(plane: Int16Array, side: number, level: number, rectangles: Rectangle[]): void {
  const axis = side >> 1;
  const place: [number, number, number] = [0, 0, 0];
  for (let first = 0; first < plane.length; first++) {
    const colour = plane[first] as number;
    if (colour === 0) continue;
    const a = first % CHUNK;
    let wide = 1;
    while (a + wide < CHUNK && plane[first + wide] === colour) wide++;
    let end = first + CHUNK;
    while (end < plane.length && isRun(plane, end, wide, colour)) end += CHUNK;
    for (let row = first; row < end; row += CHUNK) plane.fill(0, row, row + wide);
    place[axis] = level;
    place[(axis + 1) % 3] = a;
    place[(axis + 2) % 3] = (first - a) / CHUNK;
    rectangles.push([side, ...place, wide, (end - first) / CHUNK, colour - 1]);
  }
}

function isRun(plane: Int16Array, from: number, length: number, colour: number): boolean {
  for (let at = from; at < from + length; at++) if (plane[at] !== colour) return false;
  return true;
}
