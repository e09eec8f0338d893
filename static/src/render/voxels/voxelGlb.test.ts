import { describe, expect, test } from "vitest";
import { decodeVoxels, isVoxelChunk } from "../../wire/decodeVoxels";
import { mergeFaces, voxelGlb } from "./voxelGlb";
import vectors from "./voxels.vectors.json";

const bytes = (hex: string): Uint8Array =>
  Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16));

interface Accessor {
  bufferView: number;
  componentType: number;
  count: number;
  type: "SCALAR" | "VEC3" | "VEC4";
  min?: number[];
  max?: number[];
}

/** Read a GLB file's positions, colours and indices as the specification says, each a list of tuples. */
function readGlb(file: Uint8Array) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const word = (at: number) => view.getUint32(at, true);
  expect([word(0), word(4), word(8), word(16)]).toEqual([0x46546c67, 2, file.length, 0x4e4f534a]);
  const binary = 20 + word(12);
  expect([binary % 4, word(binary), word(binary + 4)]).toEqual([0, file.length - binary - 8, 0x004e4942]);
  const json = JSON.parse(new TextDecoder().decode(file.subarray(20, binary)));
  expect(json.buffers[0].byteLength).toBeLessThanOrEqual(word(binary));
  const rows = (accessor: Accessor): number[][] => {
    const bufferView = json.bufferViews[accessor.bufferView];
    const width = { SCALAR: 1, VEC3: 3, VEC4: 4 }[accessor.type];
    const size = { 5121: 1, 5123: 2, 5125: 4 }[accessor.componentType] as 1 | 2 | 4;
    const stride = bufferView.byteStride ?? width * size;
    const start = binary + 8 + bufferView.byteOffset;
    expect([start % 4, stride * accessor.count <= bufferView.byteLength]).toEqual([0, true]);
    const read = { 1: view.getUint8, 2: view.getUint16, 4: view.getUint32 }[size];
    return Array.from({ length: accessor.count }, (_, i) =>
      Array.from({ length: width }, (_, k) => read.call(view, start + i * stride + k * size, true)),
    );
  };
  const primitive = json.meshes[0].primitives[0];
  const [place, colour, index] = [primitive.attributes.POSITION, primitive.attributes.COLOR_0, primitive.indices].map(
    (number: number): Accessor => json.accessors[number],
  ) as [Accessor, Accessor, Accessor];
  return { places: rows(place), colours: rows(colour), indices: rows(index).flat(), extent: [place.min, place.max] };
}

describe.each(vectors.chunks.map((chunk, i) => [i, chunk] as const))("chunk %i as the server sends it", (_, chunk) => {
  test("its faces are merged to the server's rectangles", () => {
    expect(isVoxelChunk(bytes(chunk.hex))).toBe(true);
    expect(mergeFaces(decodeVoxels(bytes(chunk.hex)))).toEqual(chunk.rectangles);
  });

  test("the file has their triangles, seen from outside, in their colours", () => {
    const { places, colours, indices, extent } = readGlb(voxelGlb(decodeVoxels(bytes(chunk.hex))));
    expect(indices.flatMap((at) => places[at])).toEqual(chunk.triangles.flat());
    expect(colours).toEqual(chunk.colours.flatMap((colour) => Array.from({ length: 4 }, () => [...colour, 255])));
    const along = [0, 1, 2].map((axis) => places.map((place) => place[axis] as number));
    expect(extent).toEqual([along.map((all) => Math.min(...all)), along.map((all) => Math.max(...all))]);
  });
});

test("a part of a longer buffer is read", () => {
  const { hex, rectangles } = vectors.chunks[0] as (typeof vectors.chunks)[number];
  const longer = new Uint8Array([1, 2, 3, ...bytes(hex)]);
  expect(mergeFaces(decodeVoxels(longer.subarray(3)))).toEqual(rectangles);
});

test("as many faces as a chunk can have, in indices of four bytes", () => {
  const sides = Uint8Array.from({ length: 32 ** 3 }, (_, i) => (((i ^ (i >> 5) ^ (i >> 10)) & 1) === 1 ? 63 : 0));
  const chunk = { sides, numbers: new Uint8Array(32 ** 3), colours: 1, table: new Uint8Array(18) };
  const { places, indices } = readGlb(voxelGlb(chunk));
  expect(places.length).toBe(4 * 6 * 16384);
  expect(Math.max(...indices.slice(-6))).toBe(places.length - 1);
});

test.each(vectors.broken)("refused: %s", (hex) => {
  expect(() => decodeVoxels(bytes(hex))).toThrow(RangeError);
});
