import { signal } from "@preact/signals";
import HEIGHTS from "./figureHeights.json";

/** A polyline: widths of the window and heights of a figure, CSS pixels, by increasing width. */
type Polyline = readonly (readonly number[])[];

/** Linear interpolation, constant outside. */
export function heightAt(points: Polyline, width: number): number {
  const next = points.findIndex(([x = 0]) => x >= width);
  const [x1 = 0, y1 = 0] = points.at(next) ?? []; // the last one, if all are narrower
  const [x0 = 0, y0 = 0] = points[next - 1] ?? [];
  return next <= 0 ? y1 : y0 + ((width - x0) / (x1 - x0)) * (y1 - y0);
}

/**
 * The height of a section's figure in its first state, at a width of the window; 0 for an unknown section. The heights
 * were measured at all widths by `python -m tests.browser.figure_heights`: text wraps, and columns become rows, at
 * widths that differ from figure to figure.
 */
export const figureHeight = (id: string, width: number): number =>
  heightAt((HEIGHTS as Readonly<Record<string, Polyline>>)[id] ?? [], width);

/** Width of the window without its scroll bar, CSS pixels. */
export const windowWidth = signal(document.documentElement.clientWidth);

addEventListener("resize", () => {
  windowWidth.value = document.documentElement.clientWidth;
});
