/**
 * Rectangles as a binary glTF file: corners in whole voxels (KHR_mesh_quantization), colours that have the light in them
 * (KHR_materials_unlit). Source: glTF 2.0 Specification, Khronos Group, and the two extensions.
 */

import type { VoxelChunk } from "../../wire/decodeVoxels";
import { mergeFaces, type Rectangle } from "./mergeFaces";

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
