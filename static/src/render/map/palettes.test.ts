// @vitest-environment happy-dom
import { afterEach, expect, test } from "vitest";
import type { Geometry } from "../../wire/protocol";
import { Cells } from "./cells";
import type { MapPicture } from "./mapPicture";
import { PALETTE_ROWS, PALETTES, paletteOf } from "./palettes";

const map = (style: string, low = -2, high = 3.5): MapPicture => ({
  geometry: { low, high } as Geometry,
  cells: new Cells(),
  style,
});

afterEach(() => {
  delete PALETTES.stars;
});

test("a belief has a separate palette for each range", () => {
  expect(paletteOf(map("belief")).key).toBe(paletteOf(map("belief")).key);
  expect(paletteOf(map("belief")).key).not.toBe(paletteOf(map("belief", -4)).key);
});

test("a style is painted in its palette, an unknown one in the palette of values", () => {
  const unknown = paletteOf(map("stars"));
  expect(unknown.key).toBe(paletteOf(map("values")).key);
  expect(unknown.colours()).toHaveLength(256 * 4 * PALETTE_ROWS);
  PALETTES.stars = ({ low, high }) => ({ key: `stars ${low} ${high}`, colours: () => new Uint8Array(0) });
  expect(paletteOf(map("stars")).key).toBe("stars -2 3.5");
});
