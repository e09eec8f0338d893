/**
 * Rectangles as a binary glTF file: corners in whole voxels (KHR_mesh_quantization), colours that have the light in them
 * (KHR_materials_unlit). Source: glTF 2.0 Specification, Khronos Group, and the two extensions.
 */

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

const VERTEX_BYTES = 4; // x, y, z and a fourth byte, since a vertex begins at a multiple of four
/** Of the corners, counter-clockwise from outside, whether they lie at the far end along the two axes: −x, +x. */
const CORNERS = [
  [0, 0, 0, 1, 1, 1, 1, 0],
  [0, 0, 1, 0, 1, 1, 0, 1],
] as const;

/** Return the faces of a chunk, of which there are some, as a GLB file. */
export function voxelGlb(chunk: VoxelChunk): Uint8Array<ArrayBuffer> {
  const rectangles = mergeFaces(chunk);
  const vertices = 4 * rectangles.length;
  const isWide = vertices > 1 << 16;
  const blockBytes = VERTEX_BYTES * vertices;
  const indexBytes = 6 * rectangles.length * (isWide ? 4 : 2);
  const dataBytes = 2 * blockBytes + indexBytes;
  const head = new TextEncoder().encode(described(vertices, indexBytes, isWide, extent(rectangles)));
  const headBytes = (head.length + 3) & ~3;
  const binBytes = (dataBytes + 3) & ~3;
  const file = new Uint8Array(12 + 8 + headBytes + 8 + binBytes);
  const words = new DataView(file.buffer);
  for (const [at, word] of [0x46546c67, 2, file.length, headBytes, 0x4e4f534a].entries()) {
    words.setUint32(4 * at, word, true);
  }
  file.fill(0x20, 20, 20 + headBytes).set(head, 20);
  words.setUint32(20 + headBytes, binBytes, true);
  words.setUint32(24 + headBytes, 0x004e4942, true);
  const at = 28 + headBytes;
  writeVertices(rectangles, chunk, file.subarray(at, at + blockBytes), file.subarray(at + blockBytes));
  const indices = new (isWide ? Uint32Array : Uint16Array)(file.buffer, at + 2 * blockBytes, 6 * rectangles.length);
  for (let i = 0, corner = 0; i < indices.length; i += 6, corner += 4) {
    indices[i] = indices[i + 3] = corner;
    indices[i + 1] = corner + 1;
    indices[i + 2] = indices[i + 4] = corner + 2;
    indices[i + 5] = corner + 3;
  }
  return file;
}

/** Write the corners, and their colours, which have an alpha of 255. */
function writeVertices(
  rectangles: readonly Rectangle[],
  { table, colours }: VoxelChunk,
  places: Uint8Array,
  shades: Uint8Array,
): void {
  let at = 0;
  for (const [side, x, y, z, wide, high, number] of rectangles) {
    const axis = side >> 1;
    const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    const corners = CORNERS[side & 1] as readonly number[];
    const colour = 3 * (side * colours + number);
    for (let i = 0; i < 8; i += 2, at += VERTEX_BYTES) {
      places[at] = x;
      places[at + 1] = y;
      places[at + 2] = z;
      places[at + axis] = (places[at + axis] as number) + (side & 1);
      places[at + u] = (places[at + u] as number) + wide * (corners[i] as number);
      places[at + v] = (places[at + v] as number) + high * (corners[i + 1] as number);
      shades[at] = table[colour] as number;
      shades[at + 1] = table[colour + 1] as number;
      shades[at + 2] = table[colour + 2] as number;
      shades[at + 3] = 255;
    }
  }
}

/** The least and greatest coordinates of the corners. */
function extent(rectangles: readonly Rectangle[]): readonly [low: number[], high: number[]] {
  const low = [255, 255, 255];
  const high = [0, 0, 0];
  for (const rectangle of rectangles) {
    const [side, , , , wide, tall] = rectangle;
    const spans = [side & 1, wide, tall];
    for (let i = 0; i < 3; i++) {
      const axis = ((side >> 1) + i) % 3;
      const first = rectangle[1 + axis] as number;
      // Along its own axis a rectangle is in one plane.
      low[axis] = Math.min(low[axis] as number, first + (i === 0 ? side & 1 : 0));
      high[axis] = Math.max(high[axis] as number, first + (spans[i] as number));
    }
  }
  return [low, high];
}

function described(
  vertices: number,
  indexBytes: number,
  isWide: boolean,
  [min, max]: readonly [number[], number[]],
): string {
  const blockBytes = VERTEX_BYTES * vertices;
  const view = { buffer: 0, byteLength: blockBytes, byteStride: VERTEX_BYTES, target: 34962 };
  return JSON.stringify({
    asset: { version: "2.0" },
    extensionsUsed: ["KHR_mesh_quantization", "KHR_materials_unlit"],
    extensionsRequired: ["KHR_mesh_quantization"],
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, COLOR_0: 1 }, indices: 2, material: 0 }] }],
    materials: [{ extensions: { KHR_materials_unlit: {} } }],
    buffers: [{ byteLength: 2 * blockBytes + indexBytes }],
    bufferViews: [
      { ...view, byteOffset: 0 },
      { ...view, byteOffset: blockBytes },
      { buffer: 0, byteOffset: 2 * blockBytes, byteLength: indexBytes, target: 34963 },
    ],
    accessors: [
      { bufferView: 0, componentType: 5121, count: vertices, type: "VEC3", min, max },
      { bufferView: 1, componentType: 5121, normalized: true, count: vertices, type: "VEC4" },
      { bufferView: 2, componentType: isWide ? 5125 : 5123, count: 1.5 * vertices, type: "SCALAR" },
    ],
  });
}
