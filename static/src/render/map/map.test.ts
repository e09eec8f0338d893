import { describe, expect, test } from "vitest";
import { logOdds } from "../../grid/cellValues";
import type { Rgb } from "../../style/colour";
import { fromLab, toLab } from "../../style/oklab";
import { Cells } from "./cells";
import { Highlights } from "./highlights";
import { palette } from "./palettes";
import { CHUNK, emptyPyramid, LEVELS, levelFor, reduce, sideOf } from "./pyramid";
import { clipMatrix } from "./renderer";

/** The rule, stated again: the greatest byte of the square of cells under a texel. */
function greatest(cells: Uint8Array, level: number, row: number, col: number): number {
  const side = 1 << level;
  let most = 0;
  for (let r = row * side; r < (row + 1) * side; r++) {
    for (let c = col * side; c < (col + 1) * side; c++) most = Math.max(most, cells[r * CHUNK + c] ?? 0);
  }
  return most;
}

const random = (seed: number): (() => number) => {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
};

describe("the pyramid", () => {
  test("each texel is the greatest of the cells under it", () => {
    const pyramid = emptyPyramid();
    const next = random(7);
    const level0 = pyramid[0] as Uint8Array;
    for (let i = 0; i < 400; i++) level0[Math.floor(next() * level0.length)] = Math.floor(next() * 256);
    reduce(pyramid, 0, 0, CHUNK);
    for (let level = 1; level < LEVELS; level++) {
      const side = sideOf(level);
      const texels = pyramid[level] as Uint8Array;
      for (let i = 0; i < 60; i++) {
        const row = Math.floor(next() * side);
        const col = Math.floor(next() * side);
        expect(texels[row * side + col]).toBe(greatest(level0, level, row, col));
      }
    }
  });

  test("recomputing one part gives the same as recomputing all", () => {
    const cells = new Cells();
    const next = random(3);
    for (let i = 0; i < 30; i++) {
      const tile = Uint8Array.from({ length: 4096 }, () => (next() < 0.01 ? Math.floor(next() * 256) : 0x80));
      cells.setTile(Math.floor(next() * 8), Math.floor(next() * 8), tile);
    }
    const [chunk] = cells.chunks();
    const whole = emptyPyramid();
    (whole[0] as Uint8Array).set(chunk?.pyramid[0] as Uint8Array);
    reduce(whole, 0, 0, CHUNK);
    expect(chunk?.pyramid).toEqual(whole);
  });

  test("a wall one cell thick is kept up to the top level, and free space takes precedence over unobserved", () => {
    const pyramid = emptyPyramid();
    const level0 = pyramid[0] as Uint8Array;
    level0.fill(10, 0, 100);
    for (let row = 0; row < CHUNK; row++) level0[row * CHUNK + 301] = 250;
    reduce(pyramid, 0, 0, CHUNK);
    for (let level = 0; level < LEVELS; level++) {
      const side = sideOf(level);
      for (let row = 0; row < side; row++) expect(pyramid[level]?.[row * side + (301 >> level)]).toBe(250);
    }
    expect(pyramid[6]?.[0]).toBe(10);
  });

  test("a texel always covers a pixel or more", () => {
    for (const px of [8, 1, 0.99, 0.5, 0.3, 0.01, 0.0001]) {
      const level = levelFor(px);
      if (level < LEVELS - 1) expect(px * 2 ** level).toBeGreaterThanOrEqual(1 - 1e-6);
      if (level > 0) expect(px * 2 ** (level - 1)).toBeLessThan(1);
    }
    expect(levelFor(1)).toBe(0);
  });
});

describe("cells", () => {
  test("a tile's int8 come back as bytes, at negative tile indices too", () => {
    const cells = new Cells();
    const tile = new Uint8Array(4096).fill(0x80); // −128: never observed
    tile[64 * 2 + 5] = 0x81; // −127
    tile[64 * 63 + 63] = 0x7f; // 127
    cells.setTile(-1, 9, tile);
    expect(cells.at(9 * 64 + 2, -64 + 5)).toBe(1);
    expect(cells.at(9 * 64 + 63, -1)).toBe(255);
    expect(cells.at(9 * 64 + 3, -64 + 5)).toBe(0);
    expect(cells.at(5000, 5000)).toBe(0);
    expect(cells.count(100, 200)).toEqual({ free: 1, undecided: 0, occupied: 1 });
  });

  test("only new cells and cells that cross log-odds 0 are reported as changed", () => {
    const cells = new Cells();
    const changed: number[][] = [];
    const note = (row: number, col: number): void => void changed.push([row, col]);
    const tile = new Uint8Array(4096).fill(0x80);
    tile[3] = 0x10;
    cells.setTile(0, 0, tile, 100, note);
    expect(changed).toEqual([[0, 3]]);
    tile[3] = 0x11; // a little more of the same
    cells.setTile(0, 0, tile, 100, note);
    expect(changed.length).toBe(1);
    tile[3] = 0x90; // −112: from occupied to free
    cells.setTile(0, 0, tile, 100, note);
    expect(changed.length).toBe(2);
  });

  test("cells set one by one are those of a whole tile, with what lies above them and what is reported", () => {
    const [whole, single] = [new Cells(), new Cells()];
    const tile = new Uint8Array(4096).fill(0x80);
    for (const cells of [whole, single]) cells.setTile(-3, 9, tile);
    const changed: number[][][] = [[], []];
    const places = Uint16Array.of(0, 63, 64, 2000, 4095);
    const values = Uint8Array.of(0x10, 0x90, 0x7f, 0x81, 0xff);
    for (const [i, place] of places.entries()) tile[place] = values[i] as number;
    whole.setTile(-3, 9, tile, 100, (row, col) => changed[0]?.push([row, col]));
    single.setCells(-3, 9, places, values, 100, (row, col) => changed[1]?.push([row, col]));
    expect(changed[1]).toEqual(changed[0]);
    expect(changed[0]?.length).toBe(5);
    expect(single.chunk(1, -1)?.pyramid).toEqual(whole.chunk(1, -1)?.pyramid);
    expect(single.revision).toBe(whole.revision);
  });

  test("a tile of another size is refused", () => {
    expect(() => new Cells().setTile(0, 0, new Uint8Array(100))).toThrow(/4096/);
  });
});

describe("colours", () => {
  const colours = {
    unobserved: [1, 2, 3],
    free: [200, 220, 250],
    undecided: [240, 240, 230],
    occupied: [100, 40, 5],
  } as const;
  const at = (table: Uint8Array, byte: number): number[] => [...table.slice(4 * byte, 4 * byte + 3)];

  test("OKLab and back is the same colour", () => {
    for (const rgb of [
      [0, 0, 0],
      [255, 255, 255],
      [12, 200, 99],
      [176, 67, 10],
    ] as Rgb[])
      expect(fromLab(toLab(rgb))).toEqual(rgb);
  });

  test("the ends are the tokens, log-odds 0 is undecided wherever it lies in the range", () => {
    const table = palette({ low: -2, high: 3.5 }, colours);
    expect(at(table, 0)).toEqual([...colours.unobserved]);
    expect(at(table, 1)).toEqual([...colours.free]);
    expect(at(table, 255)).toEqual([...colours.occupied]);
    const zero = Math.round(1 + (254 * 2) / 5.5);
    for (const [i, value] of at(table, zero).entries())
      expect(Math.abs(value - (colours.undecided[i] ?? 0))).toBeLessThan(4);
    expect(logOdds(0.5)).toBe(0);
  });

  test("lightness falls evenly from undecided to occupied", () => {
    const table = palette({ low: -1, high: 1 }, colours);
    const lightness = (byte: number): number => toLab(at(table, byte) as unknown as Rgb)[0];
    const steps = [128, 160, 192, 224, 255].map(lightness);
    const first = (steps[0] ?? 0) - (steps[1] ?? 0);
    for (let i = 1; i < steps.length; i++) expect((steps[i - 1] ?? 0) - (steps[i] ?? 0)).toBeCloseTo(first, 1);
  });
});

describe("where a cell is drawn", () => {
  test("the matrix takes lattice points to clip space as the view does", () => {
    const geometry = { origin: [1, -2, 0.4], resolution: 0.1 } as never;
    const view = { x: 3, y: 1, scale: 0.02 };
    const size = { width: 400, height: 300 };
    const { matrix: m, cellPx } = clipMatrix(geometry, view, size);
    expect(cellPx).toBeCloseTo(5, 12);
    // Lattice (10, 5) by hand: R(0.4) · (1, 0.5) + origin, then relative to the view.
    const x = 1 + Math.cos(0.4) * 1 - Math.sin(0.4) * 0.5;
    const y = -2 + Math.sin(0.4) * 1 + Math.cos(0.4) * 0.5;
    const clip = [0, 1].map((i) => (m[i] ?? 0) * 10 + (m[3 + i] ?? 0) * 5 + (m[6 + i] ?? 0));
    expect(clip[0]).toBeCloseTo((x - 3) / (200 * 0.02), 6);
    expect(clip[1]).toBeCloseTo((y - 1) / (150 * 0.02), 6);
  });
});

test("the newest changed cells are highlighted until the highlight has faded", () => {
  const highlights = new Highlights(0);
  for (let i = 0; i < 20000; i++) highlights.add(i, 0, 100);
  expect(highlights.count).toBe(16384);
  expect(highlights.isFading(500)).toBe(true);
  expect(highlights.isFading(701)).toBe(false);
  highlights.clear();
  expect(highlights.count).toBe(0);
});

test("the box of the observed cells ends at the outermost ones, across chunks", () => {
  const cells = new Cells();
  expect(cells.observedBox()).toBeNull();
  const tile = new Uint8Array(64 * 64).fill(128); // -128: never observed
  cells.setTile(0, 0, tile);
  expect(cells.observedBox()).toBeNull();
  tile[5 * 64 + 7] = 3;
  cells.setTile(9, 1, tile); // column 9 * 64 + 7 lies in the second chunk
  tile[5 * 64 + 7] = 128;
  tile[63 * 64 + 2] = 250;
  cells.setTile(1, 3, tile);
  expect(cells.observedBox()).toEqual({ row0: 64 + 5, row1: 3 * 64 + 63, col0: 64 + 2, col1: 9 * 64 + 7 });
});
