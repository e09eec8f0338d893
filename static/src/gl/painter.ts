/** Draws a map into a 2D canvas, where no graphics card would: the same picture as `CardRenderer`'s. */

import { fromLattice } from "../lattice";
import type { Geometry } from "../protocol";
import type { MapPicture } from "../shownMap";
import { tokenRgb } from "../style/colour";
import { type Size, toScreen, type View } from "../view";
import { paintContext } from "./context";
import { Glow, strengthOf } from "./glow";
import { mapColours, palette } from "./palette";
import { rasterise } from "./raster";
import { ANY_RANGE, type MapRenderer } from "./renderer";
import { type PaintWhole, sized } from "./surface";

export class PaintRenderer implements MapRenderer {
  readonly glow = new Glow();
  readonly #canvas: HTMLCanvasElement;
  readonly #context: CanvasRenderingContext2D;
  /** The cells alone: made anew only where they, the view or the colours changed. */
  readonly #cells = document.createElement("canvas");
  #image = new ImageData(1, 1);
  #made: readonly unknown[] = [];
  #shown: unknown = null;
  #colours = new Uint32Array(256);
  #glowColour = "";
  #paletteKey = "";

  constructor(canvas: HTMLCanvasElement) {
    this.#canvas = canvas;
    this.#context = paintContext(canvas);
  }

  recolour(): void {
    this.#paletteKey = "";
  }

  draw(map: MapPicture | null, view: View, size: Size, now: number, over: PaintWhole): boolean {
    const { width, height } = this.#canvas;
    const context = this.#context;
    if (map?.cells !== this.#shown) {
      this.glow.clear();
      this.#shown = map?.cells;
    }
    this.#usePalette(map?.geometry ?? ANY_RANGE);
    context.setTransform(1, 0, 0, 1, 0, 0);
    if (map) {
      this.#refresh(map, view, size);
      context.drawImage(this.#cells, 0, 0);
    } else {
      context.fillStyle = `rgb(${mapColours().unobserved.join(" ")})`;
      context.fillRect(0, 0, width, height);
    }
    const glows = map !== null && this.#paintGlow(map.geometry, view, size, now);
    over(this.#canvas);
    return glows;
  }

  #refresh(map: MapPicture, view: View, size: Size): void {
    const { width, height } = this.#canvas;
    const basis = [map, map.cells.revision, view, this.#colours, width, height];
    if (basis.every((value, i) => value === this.#made[i])) return;
    this.#made = basis;
    sized(this.#cells, width, height);
    if (this.#image.width !== width || this.#image.height !== height) this.#image = new ImageData(width, height);
    rasterise(new Uint32Array(this.#image.data.buffer), width, map, this.#colours, view, size);
    paintContext(this.#cells).putImageData(this.#image, 0, 0);
  }

  #paintGlow(geometry: Geometry, view: View, size: Size, now: number): boolean {
    const { glow } = this;
    if (!glow.isAlive(now)) return false;
    const context = this.#context;
    const ratio = this.#canvas.width / size.width;
    const side = Math.max(1, Math.ceil((ratio * geometry.resolution) / view.scale));
    const seconds = glow.seconds(now);
    context.fillStyle = this.#glowColour;
    const { data } = glow;
    for (let i = 0; i < 3 * glow.count; i += 3) {
      const strength = strengthOf(seconds - (data[i + 2] as number));
      if (strength === 0) continue;
      const [u, v] = [(data[i] as number) + 0.5, (data[i + 1] as number) + 0.5];
      const [x, y] = toScreen(view, size, ...fromLattice(geometry, u, v));
      context.globalAlpha = strength;
      context.fillRect(Math.round(ratio * x - side / 2), Math.round(ratio * y - side / 2), side, side);
    }
    context.globalAlpha = 1;
    return true;
  }

  #usePalette(range: Pick<Geometry, "log_odds_min" | "log_odds_max">): void {
    const key = `${range.log_odds_min} ${range.log_odds_max}`;
    if (key === this.#paletteKey) return;
    this.#paletteKey = key;
    this.#colours = new Uint32Array(palette(range, mapColours()).buffer);
    this.#glowColour = `rgb(${tokenRgb("--beam-fill").join(" ")})`;
  }
}
