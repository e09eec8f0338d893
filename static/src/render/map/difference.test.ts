import { describe, expect, test } from "vitest";
import { logOddsAt, stateAt } from "../../grid/cellValues";
import { toLab } from "../../style/oklab";
import type { Geometry } from "../../wire/protocol";
import { Cells } from "./cells";
import { CombinedMap, commonLattice } from "./combinedMap";
import {
  differenceCodes,
  differencePalette,
  FIRST,
  markedCodes,
  ONLY_A,
  ONLY_B,
  SAME,
  SAME_WALL,
  spanOf,
} from "./difference";

const RANGE = { low: -2, high: 3.5 };
const WIDE = { low: -4, high: 6 };

const geometry = (rows: number, cols: number, x: number, y: number, resolution = 0.05): Geometry => ({
  type: "geometry",
  layer: 1,
  epoch: 1,
  resolution,
  rows,
  cols,
  origin: [x, y, 0],
  ...RANGE,
  tile: 64,
});

const COLOURS = {
  unobserved: [10, 10, 10],
  less: [11, 79, 138],
  none: [241, 238, 230],
  more: [166, 62, 8],
  wall: [120, 120, 120],
  apart: [90, 80, 100],
} as const;

describe("what a difference is drawn as", () => {
  const codes = differenceCodes(RANGE, RANGE);
  const at = (a: number, b: number): number => codes[(a << 8) | b] as number;

  test("equal cells are equal, and a cell that only one map has observed is distinguished", () => {
    expect(at(0, 0)).toBe(0);
    expect(at(7, 0)).toBe(ONLY_A);
    expect(at(0, 7)).toBe(ONLY_B);
    for (let i = 1; i < 256; i++) expect(at(i, i)).toBe(stateAt(i, RANGE) === "occupied" ? SAME_WALL : SAME);
  });

  test("a greater difference is a greater byte, whatever its sign, and the sign is in the last bit", () => {
    let before = { size: 0, byte: 0 };
    const sizes: { size: number; byte: number }[] = [];
    for (let i = 1; i < 256; i += 5) {
      for (let j = 1; j < 256; j += 3) {
        if (i === j) continue;
        const difference = logOddsAt(j, RANGE) - logOddsAt(i, RANGE);
        const byte = at(i, j);
        expect(byte).toBeGreaterThanOrEqual(FIRST);
        expect((byte - FIRST) % 2 === 1).toBe(difference > 0);
        sizes.push({ size: Math.abs(difference), byte: (byte - FIRST) >> 1 });
      }
    }
    for (const sized of sizes.sort((x, y) => x.size - y.size)) {
      if (sized.size > before.size + 1e-9) expect(sized.byte).toBeGreaterThanOrEqual(before.byte);
      before = sized;
    }
    expect(at(1, 255)).toBe(254);
    expect(at(255, 1)).toBe(253);
  });

  test("the same value in two ranges is no difference, a step more is one", () => {
    const mixed = differenceCodes(RANGE, WIDE);
    for (let i = 1; i < 256; i++) {
      const value = logOddsAt(i, RANGE);
      const j = Math.round(1 + (254 * (value + 4)) / 10);
      expect(mixed[(i << 8) | j]).toBeLessThanOrEqual(SAME_WALL);
      if (j + 2 < 256) expect(mixed[(i << 8) | (j + 2)]).toBeGreaterThanOrEqual(FIRST);
    }
    expect(spanOf(RANGE, WIDE)).toBe(10);
  });

  test("only the cells of the two states are marked, never unobserved ones", () => {
    const marked = markedCodes(RANGE, WIDE, { a: "unknown", b: "free" });
    let n = 0;
    for (let i = 0; i < 256; i++)
      for (let j = 0; j < 256; j++) {
        const is = stateAt(i, RANGE) === "unknown" && stateAt(j, WIDE) === "free";
        expect(marked[(i << 8) | j]).toBe(is ? 255 : 0);
        n += is ? 1 : 0;
      }
    expect(n).toBeGreaterThan(1000);
    expect(markedCodes(RANGE, RANGE, { a: "unknown", b: "unknown" })[0]).toBe(0);
    const only = markedCodes(RANGE, RANGE, "only b");
    expect([only[5], only[5 << 8], only[(5 << 8) | 5]]).toEqual([255, 0, 0]);
  });
});

describe("colours", () => {
  const table = differencePalette(COLOURS);
  const at = (byte: number, row = 0): number[] => [...table.slice(4 * (256 * row + byte), 4 * (256 * row + byte) + 3)];

  test("no difference is the neutral colour, the ends are the tokens, and lightness goes evenly to both", () => {
    expect(at(SAME)).toEqual([...COLOURS.none]);
    expect(at(253)).toEqual([...COLOURS.less]);
    expect(at(254)).toEqual([...COLOURS.more]);
    const lightness = (byte: number): number => toLab(at(byte) as unknown as [number, number, number])[0];
    for (const sign of [0, 1]) {
      const steps = [0, 31, 62, 93, 124].map((level) => lightness(FIRST + 2 * level + sign));
      for (let i = 1; i < steps.length; i++) expect(steps[i]).toBeLessThan(steps[i - 1] as number);
    }
  });

  test("stripes fall where only a has observed a cell, rise where only b has, and nothing else is striped", () => {
    expect([0, 1, 2, 3].map((row) => at(ONLY_A, row)[0])).toEqual([10, 90, 10, 90]);
    expect([0, 1, 2, 3].map((row) => at(ONLY_B, row)[0])).toEqual([10, 10, 90, 90]);
    for (const byte of [0, SAME, SAME_WALL, 5, 200]) expect(at(byte, 3)).toEqual(at(byte, 0));
  });
});

describe("two maps on one lattice", () => {
  test("the lattice contains both, wherever they are", () => {
    // The first begins two tiles to the right of the second and one below it.
    const place = commonLattice(geometry(128, 64, 6.4, -3.2), geometry(64, 128, 0, 0));
    expect(place?.a).toEqual([0, 2]);
    expect(place?.b).toEqual([1, 0]);
    expect([place?.geometry.rows, place?.geometry.cols]).toEqual([128, 192]);
    expect(place?.geometry.origin[1]).toBeCloseTo(-3.2, 9);
  });

  test("maps with other cell sizes or offsets have no common lattice", () => {
    expect(commonLattice(geometry(64, 64, 0, 0, 0.1), geometry(64, 64, 0, 0))).toBeNull();
    expect(commonLattice(geometry(64, 64, 0.02, 0), geometry(64, 64, 0, 0))).toBeNull();
  });

  test("the difference follows both maps, tile by tile", () => {
    const a = new Cells();
    const b = new Cells();
    const tile = (byte: number): Uint8Array => new Uint8Array(4096).fill(byte ^ 0x80);
    a.setTile(0, 0, tile(100));
    const place = commonLattice(geometry(64, 64, 3.2, 0), geometry(128, 128, 0, 0));
    if (!place) throw new Error("they have a lattice in common");
    const combined = new CombinedMap(a, b, place, differenceCodes(RANGE, RANGE));
    expect(combined.update().at(0, 64)).toBe(ONLY_A);
    b.setTile(1, 0, tile(100));
    expect(combined.cells.at(0, 64)).toBe(ONLY_A);
    expect(combined.update().at(0, 64)).toBe(SAME);
    b.setTile(1, 0, tile(150));
    b.setTile(0, 1, tile(150));
    expect((combined.update().at(63, 127) - FIRST) % 2).toBe(1);
    expect(combined.cells.at(64, 0)).toBe(ONLY_B);
    combined.dispose();
    a.setTile(0, 0, tile(150));
    expect(combined.update().at(0, 64)).toBeGreaterThanOrEqual(FIRST);
  });
});
