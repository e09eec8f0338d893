/** Draws a map into a 2D canvas if there is no graphics card: the same picture as `WebGLRenderer`'s. */

import { fromLattice } from "../../grid/lattice";
import { tokenRgb } from "../../style/colour";
import type { Geometry } from "../../wire/protocol";
import { type Size, toScreen, type View } from "../view";
import { canvasContext } from "./context";
import { Highlights, opacityOf } from "./highlights";
import { type Palette, paletteOf } from "./palettes";
import { overlay, rasterise } from "./raster";
import { type Layer, MAX_PALETTES, type MapRenderer } from "./renderer";
import { type PaintCanvas, resizeCanvas } from "./surface";

export class CanvasRenderer implements MapRenderer {
  readonly highlights = new Highlights();
  readonly #canvas: HTMLCanvasElement;
  readonly #context: CanvasRenderingContext2D;
  /** The cells without overlay, redrawn only if they, the view or the colours changed. */
  readonly #cells = document.createElement("canvas");
  #image = new ImageData(1, 1);
  #made: readonly unknown[] = [];
  #highlighted: unknown = null;
  readonly #palettes = new Map<string, Uint32Array>();
  #colours: { readonly background: string; readonly highlight: string } | null = null;

  constructor(canvas: HTMLCanvasElement) {
    this.#canvas = canvas;
    this.#context = canvasContext(canvas);
  }

  recolour(): void {
    this.#palettes.clear();
    this.#colours = null;
  }

  draw(layers: readonly Layer[], view: View, size: Size, now: number, over: PaintCanvas): boolean {
    const { width, height } = this.#canvas;
    const context = this.#context;
    const highlighted = layers.find((layer) => layer.hasHighlights)?.map ?? null;
    if (highlighted?.cells !== this.#highlighted) {
      this.highlights.clear();
      this.#highlighted = highlighted?.cells;
    }
    this.#colours ??= {
      background: `rgb(${tokenRgb("--map-unobserved").join(" ")})`,
      highlight: `rgb(${tokenRgb("--beam-fill").join(" ")})`,
    };
    context.setTransform(1, 0, 0, 1, 0, 0);
    if (layers.some((layer) => layer.map)) {
      this.#refresh(layers, view, size);
      context.drawImage(this.#cells, 0, 0);
    } else {
      context.fillStyle = this.#colours.background;
      context.fillRect(0, 0, width, height);
    }
    const isFading =
      highlighted !== null && this.#paintHighlights(highlighted.geometry, view, size, now, this.#colours.highlight);
    over(this.#canvas);
    return isFading;
  }

  #refresh(layers: readonly Layer[], view: View, size: Size): void {
    const { width, height } = this.#canvas;
    const basis: unknown[] = [view, width, height];
    for (const { map, palette, part } of layers) {
      basis.push(map?.cells, map?.cells.revision, map && this.#coloursOf(palette ?? paletteOf(map)));
      basis.push(...(part ?? []));
    }
    if (basis.length === this.#made.length && basis.every((value, i) => value === this.#made[i])) return;
    this.#made = basis;
    resizeCanvas(this.#cells, width, height);
    if (this.#image.width !== width || this.#image.height !== height) this.#image = new ImageData(width, height);
    const pixels = new Uint32Array(this.#image.data.buffer);
    for (const { map, palette, part = [0, 1] } of layers) {
      const [from, to] = part.map((at) => Math.round(at * width)) as [number, number];
      if (!map || from >= to) continue;
      if (palette) {
        const stripe = width > 1.5 * size.width ? 3 : 2;
        overlay(pixels, width, map, this.#coloursOf(palette), view, size, stripe);
      } else {
        rasterise(pixels, width, map, this.#coloursOf(paletteOf(map)), view, size, from, to);
      }
    }
    canvasContext(this.#cells).putImageData(this.#image, 0, 0);
  }

  #paintHighlights(geometry: Geometry, view: View, size: Size, now: number, colour: string): boolean {
    const { highlights } = this;
    if (!highlights.isFading(now)) return false;
    const context = this.#context;
    const ratio = this.#canvas.width / size.width;
    const side = Math.max(1, Math.ceil((ratio * geometry.resolution) / view.scale));
    const seconds = highlights.seconds(now);
    context.fillStyle = colour;
    const { data } = highlights;
    for (let i = 0; i < 3 * highlights.count; i += 3) {
      const opacity = opacityOf(seconds - (data[i + 2] as number));
      if (opacity === 0) continue;
      const [u, v] = [(data[i] as number) + 0.5, (data[i + 1] as number) + 0.5];
      const [x, y] = toScreen(view, size, ...fromLattice(geometry, u, v));
      context.globalAlpha = opacity;
      context.fillRect(Math.round(ratio * x - side / 2), Math.round(ratio * y - side / 2), side, side);
    }
    context.globalAlpha = 1;
    return true;
  }

  /** The colours of a palette, in four rows of 256: the same object until the page's colours change. */
  #coloursOf({ key, colours }: Palette): Uint32Array {
    let known = this.#palettes.get(key);
    if (!known) {
      if (this.#palettes.size >= MAX_PALETTES) this.#palettes.clear();
      known = new Uint32Array(colours().buffer);
      this.#palettes.set(key, known);
    }
    return known;
  }
}
