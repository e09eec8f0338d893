/** A canvas that is repainted on request, and only while it is visible. */

import { watchVisibility } from "../../ui/browser/whenIdle";
import { resizeCanvas } from "../map/surface";
import type { Size } from "../view";

/** Paints the canvas; returns whether an animation needs to be painted again in the next animation frame. */
export type Paint = (size: Size, pixelRatio: number, now: number) => boolean;

/** Statistics of painting, for the debugging hook. */
export const paintStats = { paints: 0, milliseconds: 0, slowest: 0 };

export class Picture {
  readonly #frame: HTMLElement;
  readonly #canvas: HTMLCanvasElement;
  readonly #paint: Paint;
  readonly #resized: ResizeObserver;
  readonly #unwatch: () => void;
  readonly #onSize: (size: Size) => void;
  #size: Size = { width: 0, height: 0 };
  #device: Size = { width: 0, height: 0 };
  #isSeen = true;
  #scheduled = 0;

  constructor(
    frame: HTMLElement,
    canvas: HTMLCanvasElement,
    paint: Paint,
    onSize: (size: Size) => void = () => undefined,
  ) {
    this.#frame = frame;
    this.#canvas = canvas;
    this.#paint = paint;
    this.#onSize = onSize;
    this.#resized = new ResizeObserver(() => this.#resize());
    this.#resized.observe(frame);
    this.#unwatch = watchVisibility(frame, ({ isIntersecting }) => {
      this.#isSeen = isIntersecting;
      if (!this.#isSeen) return;
      this.#align();
      this.invalidate();
    });
  }

  get size(): Size {
    return this.#size;
  }

  /** Request a repaint in the next animation frame. */
  readonly invalidate = (): void => {
    if (this.#scheduled !== 0 || !this.#isSeen) return;
    this.#scheduled = requestAnimationFrame((now) => this.#run(now));
  };

  /** Paint and read the canvas: red, green, blue, alpha at a CSS pixel; null outside. */
  readPixel(x: number, y: number): readonly number[] | null {
    const { width, height } = this.#size;
    const canvas = this.#canvas;
    if (x < 0 || y < 0 || x >= width || y >= height) return null;
    this.#run(performance.now());
    const copy = document.createElement("canvas");
    copy.width = copy.height = 1;
    const ctx = copy.getContext("2d");
    const ratio = canvas.width / width;
    ctx?.drawImage(canvas, Math.floor(x * ratio), Math.floor(y * ratio), 1, 1, 0, 0, 1, 1);
    return ctx ? [...ctx.getImageData(0, 0, 1, 1).data] : null;
  }

  dispose(): void {
    this.#resized.disconnect();
    this.#unwatch();
    cancelAnimationFrame(this.#scheduled);
    this.#scheduled = -1;
  }

  /** Align the canvas with device pixels: otherwise cells would be blurred, and blending is slow. */
  #align(): void {
    const box = this.#frame.getBoundingClientRect();
    const ratio = devicePixelRatio;
    const left = Math.ceil(box.left * ratio - 0.01);
    const top = Math.ceil(box.top * ratio - 0.01);
    const width = Math.floor(box.right * ratio + 0.01) - left;
    const height = Math.floor(box.bottom * ratio + 0.01) - top;
    if (width < 1 || height < 1) return;
    const { style } = this.#canvas;
    style.left = `${left / ratio - box.left}px`;
    style.top = `${top / ratio - box.top}px`;
    style.width = `${width / ratio}px`;
    style.height = `${height / ratio}px`;
    this.#device = { width, height };
    this.#size = { width: width / ratio, height: height / ratio };
  }

  #resize(): void {
    this.#align();
    if (this.#size.width < 1) return;
    this.#onSize(this.#size);
    // Setting a canvas's size clears it: paint in the same frame, so that it never shows empty.
    cancelAnimationFrame(this.#scheduled);
    this.#run(performance.now());
  }

  #run(now: number): void {
    this.#scheduled = 0;
    const { width, height } = this.#device;
    if (width < 1 || height < 1) return;
    resizeCanvas(this.#canvas, width, height);
    const before = performance.now();
    const moves = this.#paint(this.#size, width / this.#size.width, now);
    const took = performance.now() - before;
    paintStats.paints++;
    paintStats.milliseconds += took;
    paintStats.slowest = Math.max(paintStats.slowest, took);
    if (moves) this.invalidate();
  }
}
