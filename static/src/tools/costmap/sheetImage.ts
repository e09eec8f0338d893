import type { MapPicture } from "../../render/map/mapPicture";
import type { Palette } from "../../render/map/palettes";
import { TILE } from "../../wire/protocol";

/** A grid as an image, one pixel per cell, row 0 first. It is painted again only where its cells have changed. */
export class Sheet {
  #image: HTMLCanvasElement | null = null;
  #key: readonly unknown[] = [];

  /** The image of a map in the colours of a palette; `theme` identifies the palette. */
  of(map: MapPicture, palette: Palette, theme: unknown): HTMLCanvasElement | null {
    const key = [map.cells, map.cells.revision, theme];
    if (this.#image && key.every((part, i) => part === this.#key[i])) return this.#image;
    this.#key = key;
    const { rows, cols } = map.geometry;
    const image = this.#image ?? document.createElement("canvas");
    if (image.width !== cols || image.height !== rows) {
      image.width = cols;
      image.height = rows;
    }
    const ctx = image.getContext("2d");
    if (!ctx) return null;
    const made = ctx.createImageData(cols, rows);
    fill(new Uint32Array(made.data.buffer), map, new Uint32Array(palette.colours().buffer));
    ctx.putImageData(made, 0, 0);
    this.#image = image;
    return image;
  }
}

function fill(pixels: Uint32Array, { cells, geometry }: MapPicture, colours: Uint32Array): void {
  const { rows, cols } = geometry;
  const tile = new Uint8Array(TILE * TILE);
  pixels.fill(colours[0] as number);
  for (let ty = 0; ty * TILE < rows; ty++) {
    for (let tx = 0; tx * TILE < cols; tx++) {
      if (!cells.readTile(tx, ty, tile)) continue;
      const [high, wide] = [Math.min(TILE, rows - ty * TILE), Math.min(TILE, cols - tx * TILE)];
      for (let r = 0; r < high; r++) {
        const to = (ty * TILE + r) * cols + tx * TILE;
        for (let c = 0; c < wide; c++) pixels[to + c] = colours[tile[r * TILE + c] as number] as number;
      }
    }
  }
}
