import { describe, expect, test } from "vitest";
import { cellAt } from "../../grid/lattice";
import type { Geometry } from "../../wire/protocol";
import { toWorld } from "../view";
import { Cells } from "./cells";
import { isSoftwareRenderer } from "./context";
import { rasterise } from "./raster";

/** Cells with a pattern in which no two neighbours are alike, over parts of four chunks. */
function patterned(): Cells {
  const cells = new Cells();
  for (const tx of [6, 7, 8, 9]) {
    for (const ty of [6, 7, 8]) {
      const tile = Uint8Array.from({ length: 4096 }, (_, i) => (i * 37 + (i >> 6) * 11 + tx * 5 + ty) & 255);
      cells.setTile(tx, ty, tile);
    }
  }
  return cells;
}

/** Every byte in a colour of its own. */
const colours = Uint32Array.from({ length: 256 }, (_, byte) => 0xff000000 + 7 * byte);

/** The rule, stated again: the cell under the middle of a pixel, or the greatest of a 2ⁿ × 2ⁿ block where they are small. */
function byteUnder(cells: Cells, geometry: Geometry, x: number, y: number, side: number): number {
  const { row, col } = cellAt(geometry, x, y);
  const [r0, c0] = [Math.floor(row / side) * side, Math.floor(col / side) * side];
  let most = 0;
  for (let r = r0; r < r0 + side; r++) for (let c = c0; c < c0 + side; c++) most = Math.max(most, cells.at(r, c));
  return most;
}

describe("the map painted by the processor", () => {
  const size = { width: 60, height: 40 };
  test.each([
    ["cells of several pixels", 0, 0.013, 2, 1],
    ["cells of several pixels, turned", 0.7, 0.013, 2, 1],
    ["three cells to a pixel, the greatest of four shown", 0, 0.15, 1, 4],
    ["three cells to a pixel, turned", -2.1, 0.15, 1, 4],
    ["wide of the map", 0, 4, 1, 128],
  ])("%s", (_, yaw, scale, ratio, side) => {
    const geometry = { rows: 1000, cols: 1000, resolution: 0.05, origin: [-3, 2, yaw] } as unknown as Geometry;
    const cells = patterned();
    // Looking at the corner where four chunks meet: cell (512, 512).
    const [c, s] = [Math.cos(yaw) * 25.6, Math.sin(yaw) * 25.6];
    const view = { x: -3 + c - s + 0.011, y: 2 + s + c - 0.007, scale };
    const pixels = new Uint32Array(size.width * size.height * ratio * ratio);
    rasterise(pixels, size.width * ratio, { geometry, cells, style: "belief" }, colours, view, size);
    let seen = 0;
    for (let j = 0; j < size.height * ratio; j++) {
      for (let i = 0; i < size.width * ratio; i++) {
        const [x, y] = toWorld(view, size, (i + 0.5) / ratio, (j + 0.5) / ratio);
        const byte = byteUnder(cells, geometry, x, y, side);
        expect(pixels[j * size.width * ratio + i]).toBe(colours[byte]);
        seen += byte > 0 ? 1 : 0;
      }
    }
    expect(seen).toBeGreaterThan(1);
  });
});

test("a software renderer is distinguished from a graphics card", () => {
  expect(isSoftwareRenderer("ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)")).toBe(
    true,
  );
  expect(isSoftwareRenderer("llvmpipe (LLVM 15.0.7, 256 bits)")).toBe(true);
  expect(isSoftwareRenderer("ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)")).toBe(false);
  expect(isSoftwareRenderer("Apple GPU")).toBe(false);
});
